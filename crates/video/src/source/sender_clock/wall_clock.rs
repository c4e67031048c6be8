//! The delay of pictures by the wall-clock times of sender reports.
//!
//! A report relates the sender's RTP time to its wall clock (RFC 3550, 6.4.1), and its arrival relates RTP
//! time to ours. So offset + c, with c from the report, is the time of arrival by our wall clock less the
//! time of capture by the sender's wall clock: the difference of the wall clocks plus the delay. A wall clock
//! goes on where a connection begins anew, so that a queue that outlasts the connection is seen. A delay
//! that is longer than a queue shows that it did not go on: the sender has restarted without a clock of its
//! own.
//!
//! Wall-clock times are used once three reports in turn gave the same c to within 50 ms: some senders stamp
//! reports with whole seconds, or with the time at which a queued picture leaves. The clocks are shown to
//! agree where three reports in turn arrived at the time that they state, or up to 0.25 s later. A picture
//! whose whole latency is more than half a second is then late, also the first one.

use barrelman_vocab::time::Timestamp;

use super::arrived::SenderReport;
use super::baseline::Baseline;

/// Reports that show a property of the clocks.
const REPORTS: u32 = 3;
/// Largest difference between two c of a steady clock.
const MAX_CHANGE_NS: i128 = 50_000_000;
/// Age of a report on arrival, if both clocks agree: the network takes up to 0.25 s, the clocks differ by up
/// to 50 ms.
const AGREED_AGE_NS: std::ops::RangeInclusive<i128> = -50_000_000..=250_000_000;
/// Largest queue before a picture or a sender report.
pub(super) const MAX_QUEUE_NS: i128 = 60_000_000_000;
/// Largest latency of a picture in time.
const MAX_LATENCY_NS: i128 = 500_000_000;

#[derive(Debug, Clone, Default)]
pub(super) struct WallClock {
    /// c of the newest report of this connection.
    difference_ns: Option<i128>,
    /// Reports in turn with the same c.
    steady: u32,
    /// Whether the sender's clock has been shown to be steady, on this connection or an earlier one.
    is_steady: bool,
    /// Reports in turn that arrived at the time that they state.
    agreeing: u32,
    baseline: Option<Baseline>,
}

impl WallClock {
    /// RTP time begins anew; the wall clock goes on.
    pub(super) fn on_connected(&mut self) {
        (self.difference_ns, self.steady) = (None, 0);
    }

    /// Nothing is known any more: a clock has jumped.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Whether the sender's RTP time and its wall clock run alike.
    pub(super) const fn is_steady(&self) -> bool {
        self.is_steady
    }

    /// Takes a report. `offset_ns`: arrival less RTP time of the report.
    pub(super) fn on_report(&mut self, report: &SenderReport, offset_ns: i128) {
        let Some(sender_wall_ns) = report.sender_wall_ns else { return };
        let age_ns = report.wall_ns - sender_wall_ns;
        let difference_ns = age_ns - offset_ns;
        if let Some(before) = self.difference_ns.replace(difference_ns) {
            let is_same = (difference_ns - before).abs() <= MAX_CHANGE_NS;
            self.steady = if is_same { self.steady + 1 } else { 0 };
            if !is_same {
                (self.is_steady, self.agreeing, self.baseline) = (false, 0, None);
            }
            self.is_steady |= self.steady + 1 >= REPORTS;
        }
        self.agreeing = if AGREED_AGE_NS.contains(&age_ns) { self.agreeing + 1 } else { 0 };
    }

    /// The delay of a picture with this offset; `None`: wall-clock times are not used.
    pub(super) fn delay_ns(&mut self, offset_ns: i128, arrival: Timestamp) -> Option<i128> {
        let latency_ns = offset_ns + self.difference_ns.filter(|_| self.is_steady)?;
        let baseline = self.baseline.get_or_insert_with(|| Baseline::new(latency_ns, arrival));
        if self.agreeing >= REPORTS {
            // The baseline lies no higher than a latency in time.
            baseline.observe(MAX_LATENCY_NS, arrival);
        }
        let delay_ns = baseline.observe(latency_ns, arrival);
        if delay_ns > MAX_QUEUE_NS {
            self.forget();
            return None;
        }
        Some(delay_ns)
    }
}
