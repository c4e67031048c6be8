//! What the publisher is told of the videos.

use barrelman_video::sender_clock::VideoTiming;
use barrelman_vocab::{Timestamp, VideoNumber};
use jiff::Zoned;

use super::super::timing_text::timing_text;
use super::super::{Level, SourceSnapshot, VideoSourceState};
use super::Publisher;

impl Publisher {
    /// There is a second video, which the pilot does not see.
    pub fn add_second_video(&mut self) {
        self.state.other_video = Some(SourceSnapshot::default());
    }

    /// The pilot sees this video from now on. Of its picture nothing is known until its first frame.
    pub fn track_video(&mut self, number: VideoNumber, now: Timestamp) {
        let video = &mut self.state.video;
        let Some(other) = &mut self.state.other_video else { return };
        if video.number == number {
            return;
        }
        video.number = number;
        std::mem::swap(&mut video.source, other);
        (video.frame, video.age) = (None, None);
        let text = format!("the boat is looked for in video {}", number.count());
        self.events.add(now, Level::Info, "video-tracked", text);
        self.publish(now);
    }

    /// The state of the source of a video. What happens to the other video is no alarm.
    pub fn set_video(&mut self, number: VideoNumber, state: VideoSourceState, now: Timestamp) {
        let is_tracked = number == self.state.video.number;
        let (name, worst) = name_and_level(number, is_tracked);
        let Some(source) = self.source_mut(number) else { return };
        let before = &mut source.state;
        if *before != state {
            let was_lost = matches!(before, VideoSourceState::Lost(_));
            let (level, text) = match &state {
                VideoSourceState::Connecting => (Level::Info, format!("{name}: connecting")),
                VideoSourceState::Up => (Level::Info, format!("{name}: up")),
                VideoSourceState::Lost(reason) => (worst, format!("{name} lost: {reason}")),
                VideoSourceState::Ended => (Level::Warning, format!("the {name} has ended")),
            };
            *before = state.clone();
            match state {
                VideoSourceState::Connecting => {}
                VideoSourceState::Up => self.events.add(now, level, "video-up", text),
                VideoSourceState::Lost(_) if was_lost => {}
                VideoSourceState::Lost(_) => self.events.add(now, level, "video-lost", text),
                VideoSourceState::Ended => self.events.add(now, level, "video-ended", text),
            }
        }
        self.publish(now);
    }

    fn source_mut(&mut self, number: VideoNumber) -> Option<&mut SourceSnapshot> {
        let video = &mut self.state.video;
        if number == video.number { Some(&mut video.source) } else { self.state.other_video.as_mut() }
    }

    /// What the times of a video's pictures tell. The log gets the beginning and the end of a delay.
    pub fn set_video_timing(&mut self, number: VideoNumber, timing: VideoTiming, now: Timestamp) {
        let is_tracked = number == self.state.video.number;
        let Some(source) = self.source_mut(number) else { return };
        let before = std::mem::replace(&mut source.timing, timing);
        let text = timing_text(timing, now, &Zoned::now());
        let is_told = match (before, timing) {
            (VideoTiming::Late { since, .. }, VideoTiming::Late { since: new_since, .. }) => {
                since == new_since
            }
            _ => before == timing,
        };
        source.timing_text = text.as_deref().map(Into::into);
        if !is_told {
            let level = if timing == VideoTiming::InTime { Level::Info } else { Level::Warning };
            let text = text.as_deref().unwrap_or("the video is in time again");
            let text = if is_tracked { text.to_owned() } else { format!("video {}: {text}", number.count()) };
            tracing::warn!("{text}");
            self.events.add(now, level, "video-timing", text);
        }
        self.publish(now);
    }
}

/// What the log calls a video, and the level of its loss.
const fn name_and_level(number: VideoNumber, is_tracked: bool) -> (&'static str, Level) {
    match (number, is_tracked) {
        (VideoNumber::First, true) => ("video", Level::Alarm),
        (VideoNumber::First, false) => ("video 1", Level::Warning),
        (VideoNumber::Second, true) => ("video 2", Level::Alarm),
        (VideoNumber::Second, false) => ("video 2", Level::Warning),
    }
}
