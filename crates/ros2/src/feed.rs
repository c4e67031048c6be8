//! From the events of the console's socket to the topics.

use tokio::sync::watch;

use crate::console::api::Snapshot;
use crate::console::socket::Event;
use crate::convert::camera_rate::camera_rate;
use crate::convert::detections::Sighting;
use crate::convert::diagnostics::ConsoleState;
use crate::convert::fixes;
use crate::convert::frames::Frames;
use crate::convert::picture::Picture;
use crate::node::Topics;
use crate::wall_clock::WallClock;

/// One connection's way to the topics.
pub struct Feed<'a> {
    topics: &'a Topics,
    frames: &'a Frames,
    /// What the diagnostics say.
    state: &'a watch::Sender<ConsoleState>,
    /// Nanoseconds since 1970.
    wall_ns: fn() -> i128,
    clock: WallClock,
    vehicle: String,
    sighting: Option<Sighting>,
    commanded_at: Option<u64>,
}

impl<'a> Feed<'a> {
    /// A way for a new connection: the program may be another one.
    pub fn new(
        topics: &'a Topics,
        frames: &'a Frames,
        state: &'a watch::Sender<ConsoleState>,
        wall_ns: fn() -> i128,
    ) -> Self {
        let (clock, vehicle) = (WallClock::default(), String::new());
        Self { topics, frames, state, wall_ns, clock, vehicle, sighting: None, commanded_at: None }
    }

    /// Passes on what came. Before the first ping is answered, no time of day is known, and nothing passes.
    pub fn on_event(&mut self, event: Event) {
        match event {
            Event::Hello(hello) => {
                self.vehicle = hello.vehicle;
                self.state.send_replace(ConsoleState::Connected);
            }
            Event::Pong(pong) => {
                // Milliseconds since 1970 are exact to a quarter of a microsecond.
                let sent = (pong.sent_ms * 1e6) as i128;
                self.clock.on_pong(sent, (self.wall_ns)(), pong.now_ns);
            }
            Event::Video(unit) => self.on_video(Picture::parse(&unit)),
            Event::Snapshot(snapshot) => {
                self.on_snapshot(&snapshot);
                self.state.send_replace(ConsoleState::Known { vehicle: self.vehicle.clone(), snapshot });
            }
        }
    }

    fn on_video(&self, picture: Option<Picture>) {
        let Some(picture) = picture else { return };
        if let Some(stamp) = self.clock.time_of(picture.captured_ns) {
            self.topics.pictures.publish(picture.message(self.frames.picture(stamp)));
        }
    }

    fn on_snapshot(&mut self, snapshot: &Snapshot) {
        if self.commanded_at != Some(snapshot.at_ns)
            && let Some(stamp) = self.clock.time_of(snapshot.at_ns)
        {
            self.commanded_at = Some(snapshot.at_ns);
            self.topics.camera_rate.publish(camera_rate(snapshot.command, self.frames.camera(stamp)));
        }
        let Some(sighting) = Sighting::of(snapshot).filter(|seen| self.sighting != Some(*seen)) else {
            return;
        };
        let Some(stamp) = self.clock.time_of(sighting.captured_ns) else { return };
        self.topics.detections.publish(sighting.message(stamp, self.frames));
        if let Some(fix) = fixes::boat(snapshot, stamp, self.frames) {
            self.topics.boat.publish(fix);
        }
        self.sighting = Some(sighting);
    }
}
