//! Notices that the sender's clock was set back by so little that it looks like a delay: a camera that stamps
//! its pictures by a wall clock which is corrected.
//!
//! No queue makes the sender's time run backwards. Reordered pictures do, again and again, and the next
//! picture in order has the offset of those before, unless a queue grows meanwhile. After a set-back every
//! offset is larger by the step, and there is no second step back.

/// Smallest step back that is watched: larger than most reordering.
const MIN_STEP_NS: i128 = 250_000_000;
/// Pictures in turn whose offsets must be larger.
const PICTURES: u32 = 16;

/// The picture with the latest time, and a step back that is watched.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SetBack {
    latest: Option<Latest>,
    /// The time of the newest picture.
    newest_ns: i128,
    watch: Option<Watch>,
}

#[derive(Debug, Clone, Copy)]
struct Latest {
    sent_ns: i128,
    offset_ns: i128,
    delay_ns: i128,
}

#[derive(Debug, Clone, Copy)]
struct Watch {
    /// A smaller offset shows that the clock goes on.
    least_ns: i128,
    /// The delay before the step.
    delay_ns: i128,
    pictures: u32,
}

impl SetBack {
    /// Takes the next picture: its time by the sender's clock, and its offset. Returns the delay before the
    /// clock was set back, where this picture shows that it was.
    pub(super) fn observe(&mut self, sent_ns: i128, offset_ns: i128) -> Option<i128> {
        let goes_back = sent_ns < std::mem::replace(&mut self.newest_ns, sent_ns);
        let latest = self.latest?;
        if goes_back {
            let is_second = self.watch.take().is_some();
            let back_ns = latest.sent_ns - sent_ns;
            if !is_second && back_ns >= MIN_STEP_NS {
                let least_ns = latest.offset_ns + back_ns / 2;
                self.watch = Some(Watch { least_ns, delay_ns: latest.delay_ns, pictures: 0 });
            }
        }
        self.watch = self.watch.filter(|watch| offset_ns >= watch.least_ns);
        let watch = self.watch.as_mut()?;
        watch.pictures += 1;
        (watch.pictures >= PICTURES).then_some(watch.delay_ns)
    }

    /// Notes that picture. `begins_anew`: by another clock than that of the ones before.
    pub(super) fn note(&mut self, sent_ns: i128, offset_ns: i128, delay_ns: i128, begins_anew: bool) {
        if begins_anew {
            *self = Self { newest_ns: sent_ns, ..Self::default() };
        }
        if self.latest.is_none_or(|latest| sent_ns >= latest.sent_ns) {
            self.latest = Some(Latest { sent_ns, offset_ns, delay_ns });
        }
    }
}
