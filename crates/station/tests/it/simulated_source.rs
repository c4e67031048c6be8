//! A simulated world as a live video source.

use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_station::simulated_source::{self, LiveWorld};
use barrelman_station::source_url::SourceUrl;
use barrelman_video::{VideoSink, VideoState};
use barrelman_vocab::{EncodedUnit, NewDrive, PictureSize, PixelBox, VideoFrame};

const SMALL: PictureSize = PictureSize::new(192, 108);

/// What the world delivers.
enum Delivery {
    Target(PixelBox),
    Unit(u32),
    Frame(VideoFrame),
    Ended,
}

struct DeliverySink(Sender<Delivery>);

impl VideoSink for DeliverySink {
    fn on_unit(&mut self, unit: &EncodedUnit) {
        let _ = self.0.send(Delivery::Unit(unit.epoch));
    }

    fn on_target(&mut self, target: PixelBox) {
        let _ = self.0.send(Delivery::Target(target));
    }

    fn on_frame(&mut self, frame: VideoFrame) {
        let _ = self.0.send(Delivery::Frame(frame));
    }

    fn on_state(&mut self, state: VideoState) {
        if matches!(state, VideoState::Ended | VideoState::Failed(_)) {
            let _ = self.0.send(Delivery::Ended);
        }
    }
}

#[test]
fn a_live_world_says_where_its_boat_is_and_stamps_its_pictures() {
    let (deliveries, queue) = channel();
    let clock = Clock::start();
    let SourceUrl::Simulated(url) = SourceUrl::parse("sim:open?size=192x108").unwrap() else { panic!() };
    let source = simulated_source::spawn(&url, clock, DeliverySink(deliveries)).unwrap();
    let mut frames: Vec<VideoFrame> = Vec::new();
    let mut target = None;
    while frames.len() < 5 {
        match queue.recv_timeout(Duration::from_secs(20)).unwrap() {
            Delivery::Unit(epoch) => assert_eq!(epoch, 0),
            Delivery::Target(found) => target = target.or(Some((found, frames.len()))),
            Delivery::Frame(frame) => {
                let age = clock.now().since(frame.capture.at);
                assert!(age >= Duration::from_millis(175), "it comes after the scenario's latency: {age:?}");
                frames.push(frame);
            }
            Delivery::Ended => panic!("the world has ended"),
        }
    }
    source.stop().unwrap();
    let (target, before) = target.unwrap();
    assert_eq!(before, 0, "the boat is in the first picture of this scenario");
    assert!(target.w > 1.0 && target.u > 0.0 && target.u + target.w < 192.0, "{target}");
    assert!(frames.windows(2).all(|pair| pair[0].capture.at < pair[1].capture.at));
    assert!(frames.iter().all(|frame| frame.picture.size() == SMALL));
}

#[test]
fn another_world_takes_the_place_of_the_running_one_and_says_where_its_boat_is() {
    let (deliveries, queue) = channel();
    let clock = Clock::start();
    let SourceUrl::Simulated(url) = SourceUrl::parse("sim:rescue?size=192x108").unwrap() else { panic!() };
    let world = LiveWorld::load(&url.world).unwrap();
    let switch = world.switch().unwrap();
    let source = simulated_source::spawn_world(world, &url, clock, DeliverySink(deliveries)).unwrap();
    let (mut epoch, mut targets, mut captured) = (0, Vec::new(), Vec::new());
    while targets.len() < 2 || captured.len() < 5 {
        match queue.recv_timeout(Duration::from_secs(20)).unwrap() {
            Delivery::Unit(now) => epoch = now,
            Delivery::Target(_) => targets.push(epoch),
            Delivery::Frame(frame) => {
                assert_eq!(frame.picture.size(), SMALL);
                if captured.is_empty() {
                    let wanted = NewDrive { scenario: "two-boats".to_owned(), seed: 3 };
                    switch.begin(switch.load(&wanted).unwrap());
                }
                captured.push(frame.capture.at);
            }
            Delivery::Ended => panic!("the world has ended"),
        }
    }
    source.stop().unwrap();
    assert_eq!(targets, [0, 1], "each world says where its boat is, in its own epoch");
    assert!(captured.windows(2).all(|pair| pair[0] < pair[1]), "the times of the pictures go on");
}
