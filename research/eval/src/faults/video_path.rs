//! The way of the pictures from the camera to the program, with its faults, and the program's clock of the
//! video.

use std::collections::VecDeque;
use std::time::Duration;

use barrelman_video::sender_clock::{ArrivedPicture, SenderClock, TimingSettings};
use barrelman_vocab::Timestamp;

use super::fault::{self, Fault, FaultKind};
use super::mutant::Mutant;
use super::picture::SeenPicture;

/// From the capture of a picture to its arrival, ms. The program does not know it.
const LATENCY_MS: u64 = 120;
/// Added to it while the video is late, ms.
const LATE_MS: u64 = 700;
/// A standing delay, ms, and the time in which it grows.
const STANDING_MS: u64 = 3_000;
const GROWS_MS: u64 = 1_500;
/// A creeping delay grows by this for each millisecond.
const CREEP: f64 = 0.12;
/// By how much the sender's clock jumps back; in half of the faults it jumps ahead, ms.
/// A jump ahead that a queue explains looks like a queue that was dropped.
const CLOCK_JUMP_MS: i64 = 5_000;
/// RTP time of the start of the world, ms.
const RTP_START_MS: i64 = 47_000_000;
/// By how much the RTP time of each further connection is ahead, ms.
const NEXT_RTP_START_MS: i64 = 12_345_678;
const TICKS_PER_SECOND: u32 = 90_000;
/// How much younger than it is a picture may seem: two clocks may drift by 200 ppm in a run of 13 s.
const DRIFT_ALLOWANCE: Duration = Duration::from_millis(4);

/// A picture on its way to the program.
#[derive(Debug, Clone, Copy)]
struct Underway {
    captured_ms: u64,
    rtp: u32,
    due_ms: u64,
    picture: SeenPicture,
}

/// A picture that has arrived.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrived {
    /// The time of capture, as the program takes it.
    pub(super) captured: Timestamp,
    /// The age beyond the latency of video in time, in truth.
    pub(super) delay: Duration,
    pub(super) picture: SeenPicture,
}

/// The way of the pictures.
pub(super) struct VideoPath {
    clock: SenderClock,
    /// The sender's time at the start of the world.
    rtp_start_ms: i64,
    underway: VecDeque<Underway>,
    suspended: Duration,
    /// Whether late pictures are taken for fresh ones.
    forgets_delays: bool,
}

impl VideoPath {
    pub(super) fn new(mutant: Mutant) -> Self {
        Self {
            clock: new_clock(),
            rtp_start_ms: RTP_START_MS,
            underway: VecDeque::new(),
            suspended: Duration::ZERO,
            forgets_delays: mutant == Mutant::ForgetsDelays,
        }
    }

    /// The camera takes a picture.
    pub(super) fn send(&mut self, picture: SeenPicture, faults: &[Fault], at_ms: u64) {
        let jump_ms = match fault::active(faults, FaultKind::VideoClockJumps, at_ms) {
            Some(fault) if fault.from_ms.is_multiple_of(2) => CLOCK_JUMP_MS,
            Some(_) => -CLOCK_JUMP_MS,
            None => 0,
        };
        let rtp = ((self.rtp_start_ms + at_ms as i64 + jump_ms) * i64::from(TICKS_PER_SECOND / 1000)) as u32;
        // No picture overtakes another.
        let newest_due_ms = self.underway.back().map_or(0, |underway| underway.due_ms);
        let due_ms = newest_due_ms.max(at_ms + latency_ms(faults, at_ms));
        self.underway.push_back(Underway { captured_ms: at_ms, rtp, due_ms, picture });
    }

    /// What was under way is lost.
    pub(super) fn clear(&mut self) {
        self.underway.clear();
    }

    /// What was under way is lost, and the next connection has a clock of its own.
    pub(super) fn lose_connection(&mut self) {
        self.clear();
        self.clock = new_clock();
        self.rtp_start_ms += NEXT_RTP_START_MS;
    }

    /// Takes the pictures that have arrived. Returns the newest.
    pub(super) fn receive(&mut self, at_ms: u64, now: Timestamp) -> Option<Arrived> {
        let suspended = Duration::from_millis(at_ms).saturating_sub(now.since(Timestamp::ZERO));
        self.clock.on_suspension(suspended - std::mem::replace(&mut self.suspended, suspended));
        let mut newest = None;
        while let Some(underway) = self.underway.pop_front_if(|underway| underway.due_ms <= at_ms) {
            let picture = ArrivedPicture { rtp: underway.rtp, bytes: 5_000, arrival: now };
            let captured = self.clock.capture(picture).at;
            newest = Some(Arrived {
                captured: if self.forgets_delays { now } else { captured },
                delay: Duration::from_millis((at_ms - underway.captured_ms).saturating_sub(LATENCY_MS))
                    .saturating_sub(DRIFT_ALLOWANCE),
                picture: underway.picture,
            });
        }
        newest
    }
}

fn new_clock() -> SenderClock {
    SenderClock::new(TICKS_PER_SECOND, TimingSettings::default())
}

/// From the capture of a picture to its arrival with these faults, ms.
fn latency_ms(faults: &[Fault], at_ms: u64) -> u64 {
    let gone = faults.iter().filter(|fault| fault.kind == FaultKind::MediaProgramGone);
    let connected_ms = gone.map(|fault| fault.until_ms).filter(|until_ms| *until_ms <= at_ms).max();
    // A queue is dropped with its connection. Pictures that are late from the first one of a connection on
    // are not recognised (docs/safety.md).
    let is_of_connection = |fault: &&Fault| connected_ms.is_none_or(|ms| ms <= fault.from_ms);
    let of = |kind| faults.iter().filter(move |fault| fault.kind == kind).filter(is_of_connection);
    let is_late = of(FaultKind::VideoLate).any(|fault| fault.is_active(at_ms));
    let late_ms = if is_late { LATE_MS } else { 0 };
    // A delay that has grown stays.
    let since_ms = |kind| {
        let begun = of(kind).map(|fault| fault.from_ms).min();
        begun.map_or(0, |from_ms| at_ms.saturating_sub(from_ms))
    };
    let standing_ms = STANDING_MS * since_ms(FaultKind::VideoDelayStands).min(GROWS_MS) / GROWS_MS;
    let creeping_ms = (CREEP * since_ms(FaultKind::VideoDelayCreeps) as f64) as u64;
    LATENCY_MS + late_ms + standing_ms + creeping_ms
}
