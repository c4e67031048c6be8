use std::collections::VecDeque;

use barrelman_host::clock::Clock;
use barrelman_vocab::video::VideoFrame;

use super::*;
use crate::url::VideoUrl;

/// Makes one scripted connection after the other.
struct Scripted(VecDeque<VecDeque<ConnectionEvent>>);

struct ScriptedConnection(VecDeque<ConnectionEvent>);

impl Engine for Scripted {
    const CONNECT_TIMEOUT: Duration = Duration::from_secs(60);

    fn connect(&mut self) -> Result<impl Connection, VideoError> {
        Ok(ScriptedConnection(self.0.pop_front().expect("no further connection is made")))
    }
}

impl Connection for ScriptedConnection {
    fn next(&mut self, _until: Instant) -> ConnectionEvent {
        self.0.pop_front().expect("the connection has ended")
    }
}

/// What a sink has received: the states in words, and epoch and index of each unit.
#[derive(Default)]
struct Received {
    states: Vec<String>,
    units: Vec<(u32, u64)>,
}

impl VideoSink for &mut Received {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        self.units.push((unit.epoch, unit.index));
    }

    fn on_frame(&mut self, _frame: VideoFrame) {}

    fn on_state(&mut self, state: VideoState) {
        self.states.push(match state {
            VideoState::Lost { reason } => reason,
            other => format!("{other:?}"),
        });
    }
}

/// A connection with one picture.
fn up(end: Broken) -> VecDeque<ConnectionEvent> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/jpeg/1.jpg");
    let unit = ReceivedUnit {
        codec: UnitCodec::Jpeg,
        key: true,
        follows_loss: false,
        rotation: Rotation::None,
        time: ReceivedTime::Unknown,
        arrival: Timestamp::from_nanos(0),
        payload: std::fs::read(path).unwrap().into(),
    };
    [ConnectionEvent::Connected, ConnectionEvent::Unit(unit), ConnectionEvent::Broken(end)].into()
}

fn without_picture(end: Broken) -> VecDeque<ConnectionEvent> {
    [ConnectionEvent::Broken(end)].into()
}

fn lost() -> Broken {
    Broken::Temporary { reason: "it was lost".to_owned(), is_reached: true }
}

/// The camera sends H.265 now.
fn changed() -> VideoError {
    VideoError::Stream {
        address: "rtsp://camera/".to_owned(),
        what: "sends H265".to_owned(),
        remedy: "Set the camera to H.264".to_owned(),
    }
}

fn receive(
    patience: Option<Duration>,
    progress: Progress,
    connections: impl IntoIterator<Item = VecDeque<ConnectionEvent>>,
) -> (ReceiverEnd, Received) {
    let mut received = Received::default();
    let url = VideoUrl::parse("rtsp://127.0.0.1/video").unwrap();
    let mut feed = Feed::new(url.feed_settings(), Clock::start(), &mut received);
    let stop = StopSignal::default();
    let receiver = Receiver::new(&mut feed, patience, &stop).resuming(progress);
    let end = receiver.run(&mut Scripted(connections.into_iter().collect()));
    (end, received)
}

const PATIENCE: Option<Duration> = Some(Duration::from_secs(60));

#[test]
fn a_stream_that_changes_to_one_of_another_engine_is_left_to_it() {
    let connections = [up(lost()), without_picture(Broken::Unsupported(changed()))];
    let (end, received) = receive(PATIENCE, Progress::default(), connections);
    let ReceiverEnd::GivenUp { reason, progress } = end else { panic!("{end:?}") };
    assert_eq!(reason, "the stream sends H265");
    assert_eq!(progress, Progress { epoch: 2, units: 1, was_up: true });
    assert_eq!(received.states, ["Connecting", "Up", "it was lost", "Connecting"]);
}

#[test]
fn without_another_engine_the_stream_may_change_back() {
    let connections = [up(lost()), without_picture(Broken::Unsupported(changed())), up(Broken::Ended)];
    let (end, received) = receive(None, Progress::default(), connections);
    assert!(matches!(end, ReceiverEnd::Ended), "{end:?}");
    assert_eq!(received.units, [(0, 0), (2, 1)]);
}

#[test]
fn a_stream_that_no_engine_takes_at_first_is_refused() {
    let connections = [without_picture(Broken::Refused(changed()))];
    let (end, _) = receive(PATIENCE, Progress::default(), connections);
    assert!(matches!(end, ReceiverEnd::Failed(_)), "{end:?}");
}

#[test]
fn the_next_engine_goes_on_where_the_first_has_ended() {
    let progress = Progress { epoch: 2, units: 7, was_up: true };
    let connections = [without_picture(Broken::Refused(changed())), up(Broken::Ended)];
    let (end, received) = receive(None, progress, connections);
    assert!(matches!(end, ReceiverEnd::Ended), "{end:?}");
    assert_eq!(received.units, [(3, 7)]);
}
