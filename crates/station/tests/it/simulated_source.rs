//! A simulated world as a live video source.

use std::sync::mpsc::{Sender, channel};
use std::time::Duration;

use barrelman_host::clock::Clock;
use barrelman_station::simulated_source;
use barrelman_station::source_url::SourceUrl;
use barrelman_video::{VideoSink, VideoState};
use barrelman_vocab::{EncodedUnit, PictureSize, PixelBox, VideoFrame};

const SMALL: PictureSize = PictureSize::new(192, 108);

/// What the world delivers.
enum Delivery {
    Target(PixelBox),
    Frame(VideoFrame),
    Ended,
}

struct DeliverySink(Sender<Delivery>);

impl VideoSink for DeliverySink {
    fn unit(&mut self, _unit: &EncodedUnit) {}

    fn target(&mut self, target: PixelBox) {
        let _ = self.0.send(Delivery::Target(target));
    }

    fn frame(&mut self, frame: VideoFrame) {
        let _ = self.0.send(Delivery::Frame(frame));
    }

    fn state(&mut self, state: VideoState) {
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
