//! The tracking camera that ground stations select on.

use core::time::Duration;

use barrelman_vocab::mavlink::Address;
use barrelman_vocab::{PictureSize, PixelBox, Timestamp};
use barrelman_wire::mavlink::frame::{FrameReader, FrameWriter};
use barrelman_wire::mavlink::tracking_camera::{
    CameraDescription, CameraSettings, RequestNumber, Shown, ShownTarget, TrackingAnswer, TrackingCamera,
    TrackingRequest, VideoStream,
};
use mavlink::dialects::common::CAMERA_TRACKING_IMAGE_STATUS_DATA;

/// The messages that the camera reads, whose payloads are any bytes: heartbeat, both kinds of commands, an
/// answer.
const MESSAGES: [u32; 4] = [0, 75, 76, 77];
/// The commands that the camera knows.
const COMMANDS: [u16; 8] = [511, 512, 521, 2002, 2004, 2005, 2010, 2504];
const PICTURE: PictureSize = PictureSize { width: 1280, height: 720 };
/// Where the fields behind the parameters of a command begin.
const COMMAND_AT: usize = 28;

/// Any bytes and any messages of ground stations, and any answers of the operator gateway. What is asked for
/// lies in the picture, every packet is one frame of the camera, a told place lies in the picture, and
/// nothing is sent without bound.
pub fn tracking_camera(bytes: &[u8]) {
    let mut rest = bytes.iter().copied();
    let first = rest.next().unwrap_or(0);
    let settings = CameraSettings { marks_coasting: first & 1 == 1, ..CameraSettings::DEFAULT };
    let stream = VideoStream::new("rtsp://camera.example/live", Some(60)).filter(|_| first & 2 == 0);
    let description = CameraDescription { model: "any".to_owned(), version: [0, 1, 0], stream };
    let mut station = FrameWriter::new(Address::new(255, 190), None);
    let mut talk = Talk {
        camera: TrackingCamera::new(settings, description, None),
        now: Timestamp::from_secs_f64(1.0),
        asked: Vec::new(),
    };
    talk.camera.show(Shown {
        picture: Some(PICTURE).filter(|_| first & 4 == 0),
        frames_per_second: 30.0,
        target: ShownTarget::None,
    });
    while let Some(byte) = rest.next() {
        let value = rest.next().unwrap_or(0);
        match byte % 8 {
            0 => talk.now = talk.now.plus(Duration::from_millis(u64::from(value) * 8)),
            1 => talk.show(value, rest.next().unwrap_or(0)),
            2 => talk.answer(value),
            3 => {
                let piece: Vec<u8> = rest.by_ref().take(usize::from(value)).collect();
                talk.hear(&piece);
            }
            4 | 5 => {
                let message = MESSAGES[usize::from(value) % MESSAGES.len()];
                let length = usize::from(rest.next().unwrap_or(0) % 64);
                let payload: Vec<u8> = rest.by_ref().take(length).collect();
                talk.hear(&station.write_payload(message, &payload));
            }
            _ => {
                let command = COMMANDS[usize::from(value) % COMMANDS.len()];
                let mut payload: Vec<u8> = rest.by_ref().take(COMMAND_AT).collect();
                payload.resize(COMMAND_AT, 0);
                payload.extend(command.to_le_bytes());
                payload.extend([0, 0, 0]);
                talk.hear(&station.write_payload(76, &payload));
            }
        }
        talk.poll();
    }
}

struct Talk {
    camera: TrackingCamera,
    now: Timestamp,
    /// Requests that the gateway has not answered.
    asked: Vec<RequestNumber>,
}

impl Talk {
    fn show(&mut self, value: u8, place: u8) {
        let bounds = PixelBox {
            u: f64::from(place) * 8.0 - 300.0,
            v: f64::from(place) * 4.0 - 100.0,
            w: f64::from(value),
            h: 30.0,
        };
        let target = match value % 4 {
            0 => ShownTarget::None,
            1 => ShownTarget::Seen(bounds),
            2 => ShownTarget::Predicted(bounds),
            _ => ShownTarget::Lost,
        };
        self.camera.show(Shown { picture: Some(PICTURE), frames_per_second: 30.0, target });
    }

    fn answer(&mut self, value: u8) {
        let answer = match value % 3 {
            0 => TrackingAnswer::Accepted,
            1 => TrackingAnswer::Refused(
                "the box is too small: the least is 6x4 px".repeat(usize::from(value)),
            ),
            _ => TrackingAnswer::Superseded,
        };
        if let Some(number) = self.asked.pop() {
            self.camera.answered(number, &answer, self.now);
        }
    }

    fn hear(&mut self, bytes: &[u8]) {
        let asked = &mut self.asked;
        self.camera.received(bytes, self.now, &mut |number, request| {
            if let TrackingRequest::Select(area) = request {
                assert!([area.u, area.v, area.w, area.h].iter().all(|number| number.is_finite()), "{area:?}");
                assert!(area.w > 0.0 && area.h > 0.0, "{area:?}");
            }
            if let TrackingRequest::SelectAt(at) = request {
                assert!(at.u.is_finite() && at.v.is_finite(), "{at:?}");
            }
            asked.push(number);
        });
    }

    fn poll(&mut self) {
        let mut out = Vec::new();
        let next = self.camera.poll(self.now, &mut out);
        assert!(next > self.now, "the next call is later");
        assert!(out.len() < 400, "{} packets at once", out.len());
        for packet in out {
            let mut frames = 0;
            FrameReader::new(None, Timestamp::ZERO).read(&packet, |frame| {
                frames += 1;
                assert!(frame.from == self.camera.address(), "{frame:?}");
                if let Some(status) = frame.read::<CAMERA_TRACKING_IMAGE_STATUS_DATA>() {
                    let corners =
                        [status.rec_top_x, status.rec_top_y, status.rec_bottom_x, status.rec_bottom_y];
                    let is_in_picture = corners.iter().all(|share| (0.0..=1.0).contains(share));
                    assert!(is_in_picture || corners.iter().all(|share| share.is_nan()), "{status:?}");
                }
            });
            assert!(frames == 1, "a packet is a frame");
        }
    }
}
