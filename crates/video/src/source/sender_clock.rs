//! Estimates the time of capture of a picture from its RTP time (RFC 3550) and its time of arrival.
//!
//! RTP time counts ticks of the sender's clock from an unknown start, modulo 2^32. A picture with RTP time r
//! (seconds, unwrapped) that arrives at a has the *offset* a - r: the difference of the clocks plus the delay
//! of the picture. The difference of two quartz clocks changes by at most 200 ppm; whatever else changes the
//! offset is delay. The [`Baseline`] is the smallest offset so far, and rises by 200 ppm alone. So
//!
//! ```text
//!   delay = offset - baseline          time of capture = time of arrival - delay
//! ```
//!
//! The delay lacks the smallest latency of the stream, which the vehicle profile's nominal video latency
//! accounts for. A delay that grows by less than 200 ppm (0.7 s an hour) cannot be distinguished from drift.
//!
//! Three more sources of knowledge:
//! - A sender report (RTCP) does not wait for an encoder. Its offset is often smaller than that of any
//!   picture. Its wall-clock time tells the delay across connections ([`wall_clock`]).
//! - A sender whose clock goes on across connections is recognised, and keeps its baseline.
//! - A clock that no quartz explains is recognised ([`clock_check`]): times of arrival are used instead.
//!
//! RTP time that steps backwards, also by a little and for good ([`set_back`]), or forwards faster than a
//! queue drains, has jumped: the delay is then taken to be what it was directly before, and longer by what
//! this picture came later than the sender's interval.

mod arrived;
mod baseline;
mod clock_check;
mod picture_rate;
mod set_back;
mod wall_clock;

use std::time::Duration;

use barrelman_vocab::time::Timestamp;
use barrelman_vocab::video::{Capture, CaptureQuality};

pub use arrived::{ArrivedPicture, SenderReport};
pub use clock_check::ClockFault;

use baseline::{Baseline, nanos};
use clock_check::ClockCheck;
use picture_rate::Step;
use set_back::SetBack;
use wall_clock::{MAX_QUEUE_NS, WallClock};

/// Which clock gives the times of capture.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum ClockChoice {
    /// The sender's, as long as it can be a clock.
    #[default]
    Auto,
    /// Times of arrival.
    Arrival,
}

/// How the times of a live source are judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimingSettings {
    /// Which clock gives the times of capture.
    pub clock: ClockChoice,
    /// A picture with a larger delay is late.
    pub late_after: Duration,
}

impl Default for TimingSettings {
    fn default() -> Self {
        Self { clock: ClockChoice::Auto, late_after: Duration::from_millis(500) }
    }
}

/// What the times of the pictures tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum VideoTiming {
    /// The pictures come without a delay that grew.
    #[default]
    InTime,
    /// Every picture has been late for a second or more.
    Late {
        /// Delay of the newest picture.
        by: Duration,
        /// Arrival of the first late picture.
        since: Timestamp,
    },
    /// The sender's clock cannot be a clock: times of arrival are used, and a delay is not seen.
    ClockWrong(ClockFault),
}

impl VideoTiming {
    /// Whether there is something new to tell: another state, or a delay that differs by 0.1 s.
    pub(super) fn differs_from(self, told: Self) -> bool {
        match (self, told) {
            (Self::Late { by, since }, Self::Late { by: told_by, since: told_since }) => {
                since != told_since || by.abs_diff(told_by) >= Duration::from_millis(100)
            }
            _ => self != told,
        }
    }
}

/// Largest step backwards that reordered pictures explain, and largest step forwards that the network
/// explains.
const MAX_STEP_NS: i128 = 1_000_000_000;

/// The clock of a new connection is that of the connection before if its offset is smaller by at most this.
const MAX_EARLIER_NS: i128 = 500_000_000;

/// Pictures that are late for this long are told.
const LATE_TOLD_AFTER: Duration = Duration::from_secs(1);

/// Maps the RTP times of a source to the program's clock.
#[derive(Debug, Clone)]
pub struct SenderClock {
    ticks_per_second: u32,
    settings: TimingSettings,
    last: Option<LastPicture>,
    /// Whether no picture of this connection has arrived yet.
    is_new_connection: bool,
    baseline: Option<Baseline>,
    set_back: SetBack,
    wall: WallClock,
    check: ClockCheck,
    /// Arrival of the first of the late pictures in turn.
    late_since: Option<Timestamp>,
    /// How long the machine has been suspended. The program's clock stood still meanwhile, the sender's did
    /// not.
    suspended: Duration,
}

#[derive(Debug, Clone, Copy)]
struct LastPicture {
    /// RTP time, unwrapped.
    ticks: i64,
    /// Time of arrival by a clock that goes on while the machine is suspended.
    arrived: Timestamp,
    /// Interval to the picture before by the sender's clock.
    interval_ns: i128,
    delay_ns: i128,
    capture: Capture,
}

impl SenderClock {
    /// A clock without a picture. `ticks_per_second`: of the RTP time.
    pub fn new(ticks_per_second: u32, settings: TimingSettings) -> Self {
        Self {
            ticks_per_second,
            settings,
            last: None,
            is_new_connection: true,
            baseline: None,
            set_back: SetBack::default(),
            wall: WallClock::default(),
            check: ClockCheck::default(),
            late_since: None,
            suspended: Duration::ZERO,
        }
    }

    /// The machine was suspended for this long.
    pub fn on_suspension(&mut self, gap: Duration) {
        self.suspended += gap;
    }

    /// A new connection was made. Its RTP time may be that of the connection before, or another.
    pub fn on_connected(&mut self) {
        self.is_new_connection = true;
        self.late_since = None;
        self.wall.on_connected();
        self.check.on_connected();
    }

    /// The time of capture of a picture.
    pub fn capture(&mut self, picture: ArrivedPicture) -> Capture {
        let ArrivedPicture { arrival, bytes, .. } = picture;
        let arrived = arrival.plus(self.suspended);
        let ticks = self.unwrap(picture.rtp);
        let offset_ns = self.offset_ns(ticks, arrived);
        let is_new_connection = std::mem::replace(&mut self.is_new_connection, false);
        let step = self.last.filter(|_| !is_new_connection).map(|last| Step {
            sent_ns: self.nanos(ticks) - self.nanos(last.ticks),
            arrived_ns: i128::from(arrived.as_nanos()) - i128::from(last.arrived.as_nanos()),
        });
        let delay_before_ns =
            self.set_back.observe(self.nanos(ticks), offset_ns).filter(|_| !is_new_connection);
        let has_jumped = match (step, self.last) {
            (Some(step), Some(last)) => {
                delay_before_ns.is_some()
                    || step.sent_ns < -MAX_STEP_NS
                    || step.gained_ns() > last.delay_ns + MAX_STEP_NS
            }
            _ => false,
        };
        if let Some(delay_ns) = delay_before_ns {
            self.baseline = Some(Baseline::new(offset_ns - delay_ns, arrived));
            self.wall.forget();
        } else if has_jumped && let (Some(step), Some(last)) = (step, self.last) {
            let grown_ns = (step.arrived_ns - last.interval_ns).max(0);
            self.baseline = Some(Baseline::new(offset_ns - last.delay_ns - grown_ns, arrived));
            self.wall.forget();
        } else if is_new_connection && !self.continues(offset_ns, arrived) {
            self.baseline = None;
        }
        let baseline = self.baseline.get_or_insert_with(|| Baseline::new(offset_ns, arrived));
        let delay_ns = baseline.observe(offset_ns, arrived);
        let wall_delay_ns = if has_jumped { None } else { self.wall.delay_ns(offset_ns, arrived) };
        let delay_ns = delay_ns.max(wall_delay_ns.unwrap_or(0));
        if let Some(step) = step {
            self.check.observe(step, has_jumped, delay_ns, bytes, arrived);
        }
        self.judge_delay(delay_ns, arrival);
        let capture = match self.uses_arrival() {
            true => Capture { at: arrival.minus(self.check.jitter()), quality: CaptureQuality::Arrival },
            false => Capture { at: arrival.minus(duration(delay_ns)), quality: CaptureQuality::Sender },
        };
        let capture = self.in_order(capture, step, arrival);
        let interval_ns = match step {
            Some(step) if !has_jumped => step.sent_ns,
            _ => self.last.map_or(0, |last| last.interval_ns),
        };
        let begins_anew = has_jumped || is_new_connection;
        self.set_back.note(self.nanos(ticks), offset_ns, delay_ns, begins_anew);
        self.last = Some(LastPicture { ticks, arrived, interval_ns, delay_ns, capture });
        capture
    }

    /// Processes a sender report. A report that fits no picture is ignored.
    pub fn on_sender_report(&mut self, report: SenderReport) {
        let (Some(baseline), Some(last)) = (self.baseline, self.last.filter(|_| !self.is_new_connection))
        else {
            return;
        };
        let arrived = report.arrival.plus(self.suspended);
        let offset_ns = self.offset_ns(self.unwrap(report.rtp), arrived);
        let known_ns = baseline.at(arrived);
        if !(known_ns - MAX_QUEUE_NS..known_ns + last.delay_ns + MAX_STEP_NS).contains(&offset_ns) {
            return;
        }
        if (known_ns - MAX_STEP_NS..known_ns).contains(&offset_ns) {
            self.baseline = Some(Baseline::new(offset_ns, arrived));
        }
        self.wall.on_report(&report, offset_ns);
        self.check.set_confirmed(self.wall.is_steady());
    }

    /// What the times of the pictures so far tell.
    pub fn timing(&self) -> VideoTiming {
        if self.settings.clock == ClockChoice::Arrival {
            return VideoTiming::InTime;
        }
        if let Some(fault) = self.check.fault() {
            return VideoTiming::ClockWrong(fault);
        }
        match (self.late_since, self.last) {
            (Some(since), Some(last))
                if last.arrived.since(since.plus(self.suspended)) >= LATE_TOLD_AFTER =>
            {
                VideoTiming::Late { by: duration(last.delay_ns), since }
            }
            _ => VideoTiming::InTime,
        }
    }

    fn uses_arrival(&self) -> bool {
        self.settings.clock == ClockChoice::Arrival || self.check.fault().is_some()
    }

    fn judge_delay(&mut self, delay_ns: i128, arrival: Timestamp) {
        if duration(delay_ns) > self.settings.late_after {
            self.late_since.get_or_insert(arrival);
        } else {
            self.late_since = None;
        }
    }

    /// Times of the same clock do not run backwards while the sender's do not: where the baseline falls, the
    /// times before were too late.
    fn in_order(&self, capture: Capture, step: Option<Step>, arrival: Timestamp) -> Capture {
        match (step, self.last.map(|last| last.capture)) {
            (Some(step), Some(last)) if step.sent_ns >= 0 && last.quality == capture.quality => {
                Capture { at: capture.at.max(last.at).min(arrival), ..capture }
            }
            _ => capture,
        }
    }

    /// Whether the first picture of a connection, with this offset, comes from the same clock as the pictures
    /// before. A queue holds no more than it held plus what was captured meanwhile. A clock that begins anew
    /// has such an offset by chance in one of thousands of connections: the counter has 13 hours.
    fn continues(&self, offset_ns: i128, arrived: Timestamp) -> bool {
        let (Some(baseline), Some(last)) = (self.baseline, self.last) else { return false };
        let excess_ns = offset_ns - baseline.at(arrived);
        let gap_ns = nanos(arrived.since(last.arrived));
        (-MAX_EARLIER_NS..=last.delay_ns + gap_ns + MAX_STEP_NS).contains(&excess_ns)
    }

    /// The tick with the low 32 bits `rtp` that is nearest to the last tick.
    fn unwrap(&self, rtp: u32) -> i64 {
        let Some(last) = self.last else { return i64::from(rtp) };
        let step = rtp.wrapping_sub(last.ticks as u32) as i32;
        last.ticks.saturating_add(i64::from(step))
    }

    fn offset_ns(&self, ticks: i64, arrived: Timestamp) -> i128 {
        i128::from(arrived.as_nanos()) - self.nanos(ticks)
    }

    fn nanos(&self, ticks: i64) -> i128 {
        i128::from(ticks) * 1_000_000_000 / i128::from(self.ticks_per_second.max(1))
    }
}

/// A negative delay is none.
fn duration(delay_ns: i128) -> Duration {
    Duration::from_nanos(u64::try_from(delay_ns.max(0)).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests;
