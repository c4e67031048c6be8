//! Deliberate faults of a video source: a [`FaultPlan`] applied to the units on their way to the decoder.
//!
//! | kind | effect |
//! |---|---|
//! | stall, drop | units are lost |
//! | disconnect | the line is cut, and units are lost |
//! | delay | units are delivered [`DELAY`] late, in order |
//! | duplicate | each unit is delivered twice |
//! | corrupt | some bytes of each unit are changed, by a seeded generator of random numbers |
//! | panic | the thread panics, once |
//!
//! A network source reports the silence of a stall. `reboot` has no effect on a video.

use std::collections::VecDeque;
use std::time::Duration;

use barrelman_vocab::time::Timestamp;
use bytes::Bytes;

use barrelman_host::fault::{FaultKind, FaultPlan};
use barrelman_vocab::rng::SplitMix64;
use barrelman_vocab::unit::EncodedUnit;

/// The delay of a delayed unit.
const DELAY: Duration = Duration::from_millis(500);

/// The way of the units of one source with its planned faults. Times count from the program's start.
#[derive(Debug)]
pub(super) struct FaultyPath {
    plan: FaultPlan,
    delayed: VecDeque<(Timestamp, EncodedUnit)>,
    rng: SplitMix64,
    /// Time of the last check for planned panics.
    last_check: Option<Timestamp>,
}

impl FaultyPath {
    /// A way whose random numbers are the same in each run.
    pub(super) const fn new(plan: FaultPlan) -> Self {
        Self { plan, delayed: VecDeque::new(), rng: SplitMix64::new(0x5eed), last_check: None }
    }

    /// Why the line is cut, while it is: a network source then loses its connection.
    pub(super) fn cut(&self, at: Timestamp) -> Option<&'static str> {
        self.plan.is_active(FaultKind::Disconnect, at).then_some("the connection is cut on purpose")
    }

    /// Takes the unit that arrived at `at`, if one did, and passes the units to decode now to `out`.
    pub(super) fn pass(
        &mut self,
        unit: Option<EncodedUnit>,
        at: Timestamp,
        out: &mut dyn FnMut(EncodedUnit),
    ) {
        self.panic_if_planned(at);
        self.release(at, out);
        if let Some(unit) = unit {
            self.pass_arrived(unit, at, out);
        }
    }

    /// Panics if the plan says so.
    fn panic_if_planned(&mut self, at: Timestamp) {
        let is_due = self.plan.count_started(FaultKind::Panic, self.last_check, at) > 0;
        self.last_check = Some(at);
        assert!(!is_due, "the video thread panics because ?fault=panic asked for it");
    }

    /// Passes on what the faults leave of a unit that arrived at `at`.
    fn pass_arrived(&mut self, unit: EncodedUnit, at: Timestamp, out: &mut dyn FnMut(EncodedUnit)) {
        let is_active = |kind| self.plan.is_active(kind, at);
        if [FaultKind::Stall, FaultKind::Drop, FaultKind::Disconnect].into_iter().any(is_active) {
            return;
        }
        let (is_corrupted, is_duplicated) = (is_active(FaultKind::Corrupt), is_active(FaultKind::Duplicate));
        // A unit after the end of a delay is queued behind the delayed units.
        let due = match self.delayed.back() {
            _ if is_active(FaultKind::Delay) => Some(at.plus(DELAY)),
            Some((last, _)) => Some(*last),
            None => None,
        };
        let unit = if is_corrupted { self.corrupted(unit) } else { unit };
        for unit in is_duplicated.then(|| unit.clone()).into_iter().chain([unit]) {
            match due {
                Some(due) => self.delayed.push_back((due, unit)),
                None => out(unit),
            }
        }
    }

    /// Passes the delayed units that are due to `out`.
    fn release(&mut self, at: Timestamp, out: &mut dyn FnMut(EncodedUnit)) {
        while self.delayed.front().is_some_and(|(due, _)| *due <= at) {
            if let Some((_, unit)) = self.delayed.pop_front() {
                out(unit);
            }
        }
    }

    fn corrupted(&mut self, mut unit: EncodedUnit) -> EncodedUnit {
        let mut bytes = unit.payload.to_vec();
        // Any byte: the start of a unit and its headers, too.
        let length = bytes.len();
        for _ in 0..length.div_ceil(64).min(32) {
            let at = (self.rng.next_u64() % length as u64) as usize;
            bytes[at] ^= (self.rng.next_u64() % 255) as u8 + 1;
        }
        unit.payload = Bytes::from(bytes);
        unit
    }
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::video::{Capture, CaptureQuality};

    use super::*;
    use barrelman_vocab::unit::{Rotation, UnitCodec};

    fn unit(index: u64) -> EncodedUnit {
        EncodedUnit {
            epoch: 0,
            index,
            capture: Capture { at: Timestamp::ZERO, quality: CaptureQuality::Sender },
            key: true,
            shown: true,
            rotation: Rotation::None,
            codec: UnitCodec::H264AnnexB,
            payload: Bytes::from(vec![7; 200]),
        }
    }

    /// Ten units, one each 0.1 s from 0 on; the plan leaves these.
    fn check(plan: &str, expected: &[u64]) {
        let mut path = FaultyPath::new(FaultPlan::parse(plan).unwrap());
        let mut passed = Vec::new();
        for index in 0..10 {
            let at = Timestamp::from_nanos(index * 100_000_000);
            path.pass(Some(unit(index)), at, &mut |unit| passed.push(unit.index));
        }
        assert_eq!(passed, expected, "{plan}");
    }

    #[test]
    fn units_are_lost_doubled_and_held_back_by_plan() {
        check("", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        check("stall@0.3", &[0, 1, 2]);
        check("drop@0.3+0.2", &[0, 1, 2, 5, 6, 7, 8, 9]);
        check("disconnect@0.2+0.7", &[0, 1, 9]);
        check("duplicate@0.3+0.1,drop@0.5", &[0, 1, 2, 3, 3, 4]);
        check("delay@0.2+0.2", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
        check("delay@0.2", &[0, 1, 2, 3, 4]);
        check("reboot@0", &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]);
    }

    #[test]
    fn corruption_is_the_same_each_time() {
        let corrupted = || {
            let mut path = FaultyPath::new(FaultPlan::parse("corrupt@0").unwrap());
            let mut passed = Vec::new();
            path.pass(Some(unit(0)), Timestamp::ZERO, &mut |unit| passed.push(unit.payload));
            passed
        };
        assert_eq!(corrupted(), corrupted());
        assert_ne!(corrupted()[0], unit(0).payload);
    }

    #[test]
    fn any_byte_can_be_damaged() {
        let mut path = FaultyPath::new(FaultPlan::parse("corrupt@0").unwrap());
        let whole = unit(0).payload;
        let mut damaged = vec![false; whole.len()];
        for _ in 0..20_000 {
            path.pass(Some(unit(0)), Timestamp::ZERO, &mut |unit| {
                for (damaged, (before, after)) in
                    damaged.iter_mut().zip(whole.iter().zip(unit.payload.iter()))
                {
                    *damaged |= before != after;
                }
            });
        }
        assert!(damaged.iter().all(|damaged| *damaged), "{damaged:?}");
    }

    #[test]
    #[should_panic(expected = "?fault=panic")]
    fn a_planned_panic_happens() {
        let mut path = FaultyPath::new(FaultPlan::parse("panic@1").unwrap());
        path.pass(None, Timestamp::ZERO, &mut |_| {});
        path.pass(None, Timestamp::from_nanos(2_000_000_000), &mut |_| {});
    }
}
