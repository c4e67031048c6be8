//! The tracking camera, as ground stations use it: discovery, track commands, the status of the track, and
//! what is refused.

use barrelman_vocab::mavlink::{Address, ComponentId, SystemId};
use barrelman_vocab::{PictureSize, PixelBox, PixelPoint, Timestamp};
use barrelman_wire::mavlink::TrackingCamera;
use barrelman_wire::mavlink::frame::{Frame, FrameReader, FrameWriter};
use barrelman_wire::mavlink::tracking_camera::{
    CameraDescription, CameraSettings, RequestNumber, Shown, ShownTarget, TrackingAnswer, TrackingRequest,
    VideoStream,
};
use mavlink::MessageData;
use mavlink::dialects::common::{
    CAMERA_INFORMATION_DATA, CAMERA_TRACKING_IMAGE_STATUS_DATA, CameraTrackingMode, STATUSTEXT_DATA,
    VIDEO_STREAM_INFORMATION_DATA,
};

const PICTURE: PictureSize = PictureSize::new(1280, 720);
const GROUND_STATION: Address = Address::new(255, 190);
const ACCEPTED: u8 = 0;
const TEMPORARILY_REJECTED: u8 = 1;
const DENIED: u8 = 2;
const UNSUPPORTED: u8 = 3;
const CANCELLED: u8 = 6;
const RECTANGLE: [f32; 7] = [0.25, 0.25, 0.5, 0.75, 0.0, 0.0, 0.0];

fn at(ms: u64) -> Timestamp {
    Timestamp::from_nanos(ms * 1_000_000)
}

/// A camera with a ground station beside it.
struct Bench {
    camera: TrackingCamera,
    ground_station: FrameWriter,
    asked: Vec<(RequestNumber, TrackingRequest)>,
}

/// What the ground station heard: the number of the message, and its payload.
type Heard = Vec<(u32, Vec<u8>)>;

impl Bench {
    fn new() -> Self {
        Self::with(CameraSettings::DEFAULT)
    }

    fn with(settings: CameraSettings) -> Self {
        let stream = VideoStream::new("rtsp://camera.example/live", Some(63));
        let description = CameraDescription { model: "fotokite-pro".to_owned(), version: [0, 1, 2], stream };
        let mut camera = TrackingCamera::new(settings, description, None);
        camera.show(Shown { picture: Some(PICTURE), frames_per_second: 29.97, target: ShownTarget::None });
        Self { camera, ground_station: FrameWriter::new(GROUND_STATION, None), asked: Vec::new() }
    }

    fn show(&mut self, target: ShownTarget) {
        self.camera.show(Shown { picture: Some(PICTURE), frames_per_second: 29.97, target });
    }

    fn receive(&mut self, packet: &[u8], ms: u64) {
        self.camera.received(packet, at(ms), &mut |number, request| self.asked.push((number, request)));
    }

    /// COMMAND_LONG with this number to this address.
    fn command_to(&mut self, to: Address, number: u16, parameters: [f32; 7], ms: u64) {
        let mut payload: Vec<u8> = parameters.iter().flat_map(|parameter| parameter.to_le_bytes()).collect();
        payload.extend_from_slice(&number.to_le_bytes());
        payload.extend_from_slice(&[to.system.0, to.component.0, 0]);
        let packet = self.ground_station.write_payload(76, &payload);
        self.receive(&packet, ms);
    }

    fn command(&mut self, number: u16, parameters: [f32; 7], ms: u64) {
        self.command_to(Address::new(1, 100), number, parameters, ms);
    }

    fn poll(&mut self, ms: u64) -> Heard {
        let mut out = Vec::new();
        self.camera.poll(at(ms), &mut out);
        let mut heard = Vec::new();
        let keep = |frame: &Frame<'_>| heard.push((frame.message, frame.payload().to_vec()));
        FrameReader::new(None, Timestamp::ZERO).read(&out.concat(), keep);
        heard
    }

    /// The results of the acknowledgements that are heard now, with the numbers of their commands.
    fn acks(&mut self, ms: u64) -> Vec<(u16, u8)> {
        let heard = self.poll(ms);
        let acks = heard.iter().filter(|(message, _)| *message == 77);
        acks.map(|(_, payload)| (u16::from_le_bytes([payload[0], payload[1]]), payload[2])).collect()
    }

    fn answer(&mut self, index: usize, answer: TrackingAnswer, ms: u64) {
        let number = self.asked[index].0;
        self.camera.answered(number, &answer, at(ms));
    }
}

fn read<D: MessageData>(heard: &Heard) -> Option<D> {
    let (_, payload) = heard.iter().find(|(message, _)| *message == D::ID)?;
    D::deser(mavlink::MavlinkVersion::V2, payload).ok()
}

fn texts(heard: &Heard) -> String {
    let texts = heard.iter().filter(|(message, _)| *message == 253);
    let read = |payload: &[u8]| {
        let text = STATUSTEXT_DATA::deser(mavlink::MavlinkVersion::V2, payload).ok()?;
        text.text.to_str().ok().map(str::to_owned)
    };
    texts.filter_map(|(_, payload)| read(payload)).collect()
}

fn numbers(heard: &Heard) -> Vec<u32> {
    heard.iter().map(|(message, _)| *message).collect()
}

#[test]
fn the_camera_appears_with_the_first_picture() {
    let mut bench = Bench::new();
    bench.camera.show(Shown::default());
    assert_eq!(bench.poll(0), vec![]);
    bench.command(512, [259.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
    assert_eq!(bench.acks(10), vec![(512, TEMPORARILY_REJECTED)]);
    bench.show(ShownTarget::None);
    assert_eq!(numbers(&bench.poll(100)), vec![0]);
    assert_eq!(numbers(&bench.poll(1099)), Vec::<u32>::new());
    assert_eq!(numbers(&bench.poll(1100)), vec![0]);
}

#[test]
fn the_camera_joins_the_system_of_the_first_autopilot_unless_it_has_one() {
    let heartbeat = |system: u8, component: u8, kind: u8, autopilot: u8| {
        let payload = [0, 0, 0, 0, kind, autopilot, 0, 4, 3];
        FrameWriter::new(Address::new(system, component), None).write_payload(0, &payload)
    };
    let mut bench = Bench::new();
    bench.receive(&heartbeat(255, 190, 6, 8), 0);
    bench.receive(&heartbeat(9, 1, 18, 8), 0);
    assert_eq!(bench.camera.address(), Address::new(1, 100));
    bench.receive(&heartbeat(7, 1, 2, 3), 0);
    bench.receive(&heartbeat(8, 1, 2, 3), 0);
    assert_eq!(bench.camera.address(), Address::new(7, 100));
    let settings =
        CameraSettings { system: Some(SystemId(3)), component: ComponentId(101), ..CameraSettings::DEFAULT };
    let mut bench = Bench::with(settings);
    bench.receive(&heartbeat(7, 1, 2, 3), 0);
    assert_eq!(bench.camera.address(), Address::new(3, 101));
}

#[test]
fn camera_and_stream_are_described_by_new_and_old_requests() {
    for (number, first) in [(512, 259.0), (521, 1.0)] {
        let mut bench = Bench::new();
        bench.poll(0);
        bench.command(number, [first, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
        let heard = bench.poll(10);
        assert_eq!(numbers(&heard), vec![77, 259, 269], "the acknowledgement first, the stream unasked");
        let information: CAMERA_INFORMATION_DATA = read(&heard).unwrap();
        assert_eq!((information.resolution_h, information.resolution_v), (1280, 720));
        assert_eq!(information.flags.bits(), 256 + 512 + 1024);
        assert_eq!(information.firmware_version, 0x0002_0100);
        assert!(information.vendor_name.starts_with(b"Barrelman\0"));
        assert!(information.model_name.starts_with(b"fotokite-pro\0"));
        assert_eq!(information.cam_definition_uri.to_str(), Ok(""));
        let stream: VIDEO_STREAM_INFORMATION_DATA = read(&heard).unwrap();
        assert_eq!(stream.uri.to_str(), Ok("rtsp://camera.example/live"));
        assert_eq!((stream.stream_id, stream.count, stream.hfov), (1, 1, 63));
        assert_eq!((stream.resolution_h, stream.resolution_v), (1280, 720));
    }
    for (number, first, message) in [
        (512, 260.0, 260),
        (522, 1.0, 260),
        (512, 261.0, 261),
        (525, 0.0, 261),
        (512, 262.0, 262),
        (527, 1.0, 262),
        (512, 269.0, 269),
        (2504, 0.0, 269),
        (512, 270.0, 270),
        (2505, 0.0, 270),
        (512, 275.0, 275),
    ] {
        let mut bench = Bench::new();
        bench.poll(0);
        bench.command(number, [first, f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
        assert_eq!(numbers(&bench.poll(10)), vec![77, message], "{number} {first}");
    }
}

#[test]
fn a_camera_without_a_stream_says_so() {
    let mut bench = Bench::new();
    let description = CameraDescription { model: "simulator".to_owned(), version: [0, 1, 0], stream: None };
    bench.camera = TrackingCamera::new(CameraSettings::DEFAULT, description, None);
    bench.show(ShownTarget::None);
    bench.poll(0);
    bench.command(512, [259.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
    let heard = bench.poll(10);
    assert_eq!(numbers(&heard), vec![77, 259]);
    assert_eq!(read::<CAMERA_INFORMATION_DATA>(&heard).unwrap().flags.bits(), 512 + 1024);
    bench.command(512, [269.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 20);
    bench.command(2502, [0.0; 7], 20);
    assert_eq!(bench.acks(20), vec![(512, UNSUPPORTED), (2502, UNSUPPORTED)]);
    assert_eq!(VideoStream::new(&format!("rtsp://{}", "x".repeat(160)), None), None);
}

#[test]
fn a_rectangle_is_a_box_of_the_picture_and_a_point_a_point() {
    let mut bench = Bench::new();
    bench.command(2005, RECTANGLE, 0);
    // The radius does not matter: the size of the object is measured.
    bench.command(2004, [0.5, 0.25, 0.05, 0.0, 0.0, 0.0, 0.0], 1);
    bench.command(2004, [0.0, 1.0, f32::NAN, f32::NAN, 0.0, 0.0, 0.0], 2);
    let asked: Vec<TrackingRequest> = bench.asked.iter().map(|(_, request)| *request).collect();
    assert_eq!(
        asked,
        [
            TrackingRequest::Select(PixelBox { u: 320.0, v: 180.0, w: 320.0, h: 360.0 }),
            TrackingRequest::SelectAt(PixelPoint { u: 640.0, v: 180.0 }),
            TrackingRequest::SelectAt(PixelPoint { u: 0.0, v: 719.5 }),
        ]
    );
}

#[test]
fn a_selection_is_acknowledged_by_the_gateways_answer_or_in_time() {
    let refused = || TrackingAnswer::Refused("the selection is too small".to_owned());
    for (answer, result) in
        [(TrackingAnswer::Accepted, ACCEPTED), (refused(), DENIED), (TrackingAnswer::Superseded, CANCELLED)]
    {
        let mut bench = Bench::new();
        bench.command(2005, RECTANGLE, 0);
        assert_eq!(bench.acks(100), vec![]);
        bench.answer(0, answer, 200);
        assert_eq!(bench.acks(200), vec![(2005, result)]);
        assert_eq!(bench.acks(900), vec![], "acknowledged once");
    }
    let mut bench = Bench::new();
    bench.command(2005, RECTANGLE, 0);
    assert_eq!(bench.acks(399), vec![]);
    assert_eq!(bench.acks(400), vec![(2005, ACCEPTED)], "before a ground station repeats its command");
    bench.answer(0, refused(), 600);
    let heard = bench.poll(600);
    assert!(!numbers(&heard).contains(&77));
    assert_eq!(texts(&heard), "the selection is too small");
}

#[test]
fn a_repeated_selection_selects_once_and_a_refused_one_may_be_made_again() {
    let mut bench = Bench::new();
    bench.command(2005, RECTANGLE, 0);
    bench.command(2005, RECTANGLE, 300);
    assert_eq!(bench.asked.len(), 1);
    assert_eq!(bench.acks(400), vec![(2005, ACCEPTED)]);
    bench.command(2005, RECTANGLE, 900);
    assert_eq!((bench.asked.len(), bench.acks(900)), (1, vec![(2005, ACCEPTED)]), "the answer was lost");
    bench.answer(0, TrackingAnswer::Refused("lost".to_owned()), 950);
    bench.poll(950);
    bench.command(2005, RECTANGLE, 1000);
    assert_eq!(bench.asked.len(), 2);
    bench.command(2005, [0.2, 0.2, 0.4, 0.4, 0.0, 0.0, 0.0], 1100);
    assert_eq!(bench.asked.len(), 3, "another rectangle");
}

#[test]
fn stopping_is_taken_each_time_and_accepted_with_nothing_tracked() {
    let mut bench = Bench::new();
    for index in 0..3 {
        bench.command(2010, [0.0; 7], index * 10);
        assert_eq!(bench.asked.len(), index as usize + 1);
        bench.answer(index as usize, TrackingAnswer::Accepted, index * 10);
        assert_eq!(bench.acks(index * 10), vec![(2010, ACCEPTED)]);
    }
    assert!(bench.asked.iter().all(|(_, request)| *request == TrackingRequest::Forget));
    for index in 0..40_u8 {
        let shift = f32::from(index) * 0.01;
        bench.command(2005, [shift, 0.1, shift + 0.2, 0.3, 0.0, 0.0, 0.0], 100);
    }
    let before = bench.asked.len();
    bench.command(2010, [0.0; 7], 110);
    assert_eq!(bench.asked.len(), before + 1, "whatever waits");
    assert!(before < 15, "selections that wait are bounded: {before}");
}

#[test]
fn bad_selections_are_refused_with_a_reason_and_ask_for_nothing() {
    let nan = f32::NAN;
    for (number, parameters) in [
        (2005, [0.5, 0.25, 0.25, 0.75, 0.0, 0.0, 0.0]),
        (2005, [0.25, 0.25, 0.25, 0.75, 0.0, 0.0, 0.0]),
        (2005, [nan, 0.25, 0.5, 0.75, 0.0, 0.0, 0.0]),
        (2005, [0.25, 0.25, f32::INFINITY, 0.75, 0.0, 0.0, 0.0]),
        (2005, [-0.2, 0.25, 0.5, 0.75, 0.0, 0.0, 0.0]),
        (2005, [320.0, 180.0, 640.0, 540.0, 0.0, 0.0, 0.0]),
        (2005, [0.25, 0.25, 0.5, 0.75, 3.0, 0.0, 0.0]),
        (2004, [nan, 0.5, 0.05, 0.0, 0.0, 0.0, 0.0]),
        (2004, [0.5, 1.5, 0.05, 0.0, 0.0, 0.0, 0.0]),
        (2004, [0.5, 0.5, 0.05, 7.0, 0.0, 0.0, 0.0]),
        (2010, [4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
    ] {
        let mut bench = Bench::new();
        bench.command(number, parameters, 0);
        assert_eq!(bench.asked, vec![], "{parameters:?}");
        let heard = bench.poll(0);
        assert!(!texts(&heard).is_empty(), "{parameters:?}");
        let ack = heard.iter().find(|(message, _)| *message == 77).unwrap();
        assert_eq!(ack.1[2], DENIED, "{parameters:?}");
        assert_eq!(ack.1[8..10], [255, 190], "to who asked");
    }
}

#[test]
fn ground_stations_that_say_nan_and_commands_as_integers_are_understood() {
    let nan = f32::NAN;
    let mut bench = Bench::new();
    bench.command(2005, [0.25, 0.25, 0.5, 0.75, nan, nan, nan], 0);
    bench.command(2005, [0.25, 0.25, 0.5, 0.75, 100.0, 0.0, 0.0], 10);
    let mut payload: Vec<u8> =
        [0.1_f32, 0.1, 0.3, 0.3].iter().flat_map(|value| value.to_le_bytes()).collect();
    payload.extend_from_slice(&0_i32.to_le_bytes());
    payload.extend_from_slice(&i32::MAX.to_le_bytes());
    payload.extend_from_slice(&0_f32.to_le_bytes());
    payload.extend_from_slice(&2005_u16.to_le_bytes());
    payload.extend_from_slice(&[1, 100, 0, 0, 0]);
    let packet = bench.ground_station.write_payload(75, &payload);
    bench.receive(&packet, 20);
    assert_eq!(bench.asked.len(), 3);
}

#[test]
fn the_status_of_the_track_comes_at_the_interval_that_is_asked_for() {
    let statuses = |bench: &mut Bench, from: u64, until: u64| {
        (from..until)
            .map(|ms| numbers(&bench.poll(ms)).iter().filter(|id| **id == 275).count())
            .sum::<usize>()
    };
    let mut bench = Bench::new();
    assert_eq!(statuses(&mut bench, 0, 1000), 0, "not unless asked for");
    bench.command(511, [275.0, 500_000.0, 0.0, 0.0, 0.0, 0.0, 0.0], 1000);
    assert_eq!(statuses(&mut bench, 1000, 3000), 4);
    bench.command(511, [275.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 3000);
    assert_eq!(statuses(&mut bench, 3000, 4000), 50, "not faster than 50 Hz");
    bench.command(511, [275.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0], 4000);
    assert_eq!(statuses(&mut bench, 4000, 5000), 0);
    bench.command(2005, RECTANGLE, 5000);
    assert_eq!(statuses(&mut bench, 5000, 6000), 5, "with every selection, also after -1");
    bench.command(511, [275.0, f32::NAN, 0.0, 0.0, 0.0, 0.0, 0.0], 6000);
    bench.command(511, [0.0, 500_000.0, 0.0, 0.0, 0.0, 0.0, 0.0], 6000);
    assert_eq!(bench.acks(6000), vec![(511, DENIED), (511, UNSUPPORTED)]);
}

#[test]
fn the_status_is_a_rectangle_in_shares_of_the_picture() {
    let bounds = PixelBox { u: 320.0, v: 180.0, w: 320.0, h: 360.0 };
    let shown = |target: ShownTarget, marks_coasting: bool| {
        let mut bench = Bench::with(CameraSettings { marks_coasting, ..CameraSettings::DEFAULT });
        bench.show(target);
        bench.command(512, [275.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0);
        read::<CAMERA_TRACKING_IMAGE_STATUS_DATA>(&bench.poll(0)).unwrap()
    };
    let seen = shown(ShownTarget::Seen(bounds), false);
    assert_eq!(seen.tracking_status.bits(), 1, "exactly ACTIVE");
    assert_eq!(seen.tracking_mode, CameraTrackingMode::CAMERA_TRACKING_MODE_RECTANGLE);
    assert_eq!(seen.target_data.bits(), 4);
    assert_eq!(
        [seen.rec_top_x, seen.rec_top_y, seen.rec_bottom_x, seen.rec_bottom_y],
        [0.25, 0.25, 0.5, 0.75]
    );
    let clipped = shown(ShownTarget::Seen(PixelBox { u: -20.0, w: 340.0, ..bounds }), false);
    assert_eq!((clipped.rec_top_x, clipped.rec_bottom_x), (0.0, 0.25));
    assert_eq!(shown(ShownTarget::Predicted(bounds), false).tracking_status.bits(), 1);
    assert_eq!(shown(ShownTarget::Predicted(bounds), true).tracking_status.bits(), 9);
    let lost = shown(ShownTarget::Lost, false);
    assert_eq!((lost.tracking_status.bits(), lost.rec_top_x.is_nan()), (2, true));
    let none = shown(ShownTarget::None, false);
    assert_eq!((none.tracking_status.bits(), none.target_data.bits()), (0, 0));
}

#[test]
fn every_command_to_the_camera_is_answered_and_no_other_one() {
    let mut bench = Bench::new();
    for number in [1, 22, 176, 400, 530, 531, 1000, 2000, 2006, 2500, 42_428, 65_535] {
        bench.command(number, [1.0; 7], 0);
        assert_eq!(bench.acks(0), vec![(number, UNSUPPORTED)]);
    }
    for to in [Address::new(1, 1), Address::new(2, 100), Address::new(1, 101)] {
        bench.command_to(to, 2005, RECTANGLE, 10);
        bench.command_to(to, 512, [259.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
    }
    bench.command_to(Address::EVERYONE, 400, [1.0; 7], 10);
    bench.command_to(Address::new(1, 0), 512, [280.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
    assert_eq!((bench.acks(10), bench.asked.len()), (vec![], 0));
    bench.command_to(Address::new(1, 0), 512, [259.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], 20);
    assert_eq!(bench.acks(20), vec![(512, ACCEPTED)], "discovery by asking all");
}

#[test]
fn a_refusal_in_words_is_sent_in_parts() {
    let mut bench = Bench::new();
    bench.command(2005, RECTANGLE, 0);
    let reason = "the track was lost before it could be confirmed; the boat may be hidden – select it again"
        .to_owned();
    bench.answer(0, TrackingAnswer::Refused(reason.clone()), 10);
    let heard = bench.poll(10);
    assert_eq!(texts(&heard), reason.replace('–', "?"));
    assert_eq!(numbers(&heard).iter().filter(|message| **message == 253).count(), 2);
}

#[test]
fn the_stream_has_its_frame_rate_and_a_stream_that_there_is_not_is_denied() {
    for (command, parameters, result) in [
        (512, [269.0, 0.0], ACCEPTED),
        (512, [269.0, 1.0], ACCEPTED),
        (512, [269.0, f32::NAN], ACCEPTED),
        (512, [269.0, 2.0], DENIED),
        (512, [269.0, -1.0], DENIED),
        (512, [270.0, 2.0], DENIED),
        (2504, [1.0, 0.0], ACCEPTED),
        (2504, [3.0, 0.0], DENIED),
        (2505, [3.0, 0.0], DENIED),
        (2502, [0.0, 0.0], ACCEPTED),
        (2502, [2.0, 0.0], DENIED),
        (2503, [2.0, 0.0], DENIED),
        // Not one of a stream.
        (512, [259.0, 2.0], ACCEPTED),
    ] {
        let mut bench = Bench::new();
        let [first, second] = parameters;
        bench.command(command, [first, second, 0.0, 0.0, 0.0, 0.0, 0.0], 10);
        let heard = bench.poll(10);
        let acks: Vec<u8> = heard
            .iter()
            .filter(|(id, _)| *id == 77)
            .map(|(_, payload)| payload.get(2).copied().unwrap_or(0))
            .collect();
        assert_eq!(acks, [result], "{command} {parameters:?}");
        let is_of_stream = first == 269.0 || command == 2504;
        let stream: Option<VIDEO_STREAM_INFORMATION_DATA> = read(&heard).filter(|_| is_of_stream);
        assert_eq!(stream.is_some(), is_of_stream && result == ACCEPTED, "{command} {parameters:?}");
        assert!(stream.is_none_or(|stream| (stream.framerate - 29.97).abs() < 1e-3));
    }
}
