//! How fast the sender's time advances against the time of arrival, and what the intervals of arrival depend
//! on.

/// Length of a segment whose rate is computed, nanoseconds of arrival: 25 pictures a second and a jitter of
/// 20 ms give an error of 6 %.
const SEGMENT_NS: i128 = 1_000_000_000;
/// Largest difference of a segment's rate from the mean of the segments before it; of a fast clock as a share
/// of it.
pub(super) const RATE_TOLERANCE: f64 = 0.08;
/// Pictures from which on a correlation is computed.
const MIN_PICTURES: f64 = 60.0;
/// Sizes of pictures that vary less than this, relative to their mean, tell nothing.
const MIN_VARIATION: f64 = 0.2;
/// Largest correlation of sizes and intervals on a link that is not saturated. On a saturated link it is 1:
/// bytes come at a constant rate, so that a large picture takes longer.
const MAX_CORRELATION: f64 = 0.5;

/// From one picture to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Step {
    /// Of the sender's time.
    pub(super) sent_ns: i128,
    /// Of the time of arrival.
    pub(super) arrived_ns: i128,
}

impl Step {
    /// How much faster the sender's time advanced.
    pub(super) const fn gained_ns(self) -> i128 {
        self.sent_ns - self.arrived_ns
    }
}

/// The rate of the sender's time on one connection: seconds sent for each second of arrival. The first
/// segment does not count: servers begin with a burst of stored pictures.
#[derive(Debug, Clone, Default)]
pub(super) struct PictureRate {
    segment: Step,
    segments: u32,
    sum: f64,
    is_unsteady: bool,
}

impl PictureRate {
    /// Takes a step from one picture to the next. Returns the rate of a segment that it completes.
    pub(super) fn observe(&mut self, step: Step) -> Option<f64> {
        self.segment.sent_ns += step.sent_ns;
        self.segment.arrived_ns += step.arrived_ns;
        if self.segment.arrived_ns < SEGMENT_NS {
            return None;
        }
        let segment = std::mem::take(&mut self.segment);
        let rate = segment.sent_ns as f64 / segment.arrived_ns as f64;
        self.segments += 1;
        if self.segments == 1 {
            return None;
        }
        let counted = f64::from(self.segments - 1);
        if counted > 1.0 {
            let mean = self.sum / (counted - 1.0);
            self.is_unsteady |= (rate - mean).abs() > RATE_TOLERANCE * mean.max(1.0);
        }
        self.sum += rate;
        Some(rate)
    }

    /// The rate, where it has been the same from the first picture on, for this many segments at least.
    pub(super) fn steady(&self, min_segments: u32) -> Option<f64> {
        let counted = self.segments.saturating_sub(1);
        (!self.is_unsteady && counted >= min_segments.max(1)).then(|| self.sum / f64::from(counted))
    }

    /// The segment in progress contains a jump.
    pub(super) fn drop_segment(&mut self) {
        self.segment = Step::default();
    }
}

/// The correlation of the sizes of pictures with the intervals to the next picture.
#[derive(Debug, Clone, Default)]
pub(super) struct SizeCorrelation {
    count: f64,
    bytes: f64,
    bytes_squared: f64,
    interval: f64,
    interval_squared: f64,
    product: f64,
}

impl SizeCorrelation {
    /// A picture of this size was followed by the next one after this interval, seconds.
    pub(super) fn observe(&mut self, bytes: usize, interval_s: f64) {
        let bytes = bytes as f64;
        self.count += 1.0;
        self.bytes += bytes;
        self.bytes_squared += bytes * bytes;
        self.interval += interval_s;
        self.interval_squared += interval_s * interval_s;
        self.product += bytes * interval_s;
    }

    /// Whether the pictures were shown to come at a pace of their own, and not as fast as a saturated link
    /// lets them.
    pub(super) fn is_link_free(&self) -> bool {
        let (mean_bytes, mean_interval) = (self.bytes / self.count, self.interval / self.count);
        let bytes_variance = self.bytes_squared / self.count - mean_bytes * mean_bytes;
        let interval_variance = self.interval_squared / self.count - mean_interval * mean_interval;
        let covariance = self.product / self.count - mean_bytes * mean_interval;
        let varies = bytes_variance > (MIN_VARIATION * mean_bytes) * (MIN_VARIATION * mean_bytes);
        let deviations = (bytes_variance.max(0.0) * interval_variance.max(0.0)).sqrt();
        self.count >= MIN_PICTURES && varies && covariance <= MAX_CORRELATION * deviations
    }
}
