//! Plans of deliberate faults: which fault occurs, and when.
//!
//! A fault is written `KIND@SECONDS[+DURATION]`, several separated by commas: `stall@12.5s,drop@3+2` stalls
//! from 12.5 s without end, and drops what arrives between 3 s and 5 s. All times count from the program's
//! start. Every port and video source takes a plan, so that tests, the simulator and the bench inject faults
//! in the same way. The plan only says *whether* a fault is active. Its effect on packets or video units is
//! implemented where they pass.

use std::fmt;
use std::time::Duration;

use barrelman_vocab::time::Timestamp;

/// The kinds of faults. An *item* is a packet or a video unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaultKind {
    /// No item arrives, and no error, as when the tether is disconnected.
    Stall,
    /// Items are dropped.
    Drop,
    /// Items are delivered late.
    Delay,
    /// Items are delivered twice.
    Duplicate,
    /// Some bytes of each item are changed.
    Corrupt,
    /// The connection breaks, and no connection is possible while the fault lasts.
    Disconnect,
    /// An emulated vehicle restarts.
    Reboot,
    /// The thread panics, to test that the program stops.
    Panic,
    /// The whole process is stopped (SIGSTOP) and goes on after the duration, as in a suspend of the machine.
    Suspend,
    /// An emulated vehicle gives the control to another client.
    Takeover,
    /// An emulated vehicle takes everything and answers nothing.
    Silence,
    /// The thread does not come back, as in a deadlock.
    Hang,
    /// The connection is cut without a word: nothing passes in either direction.
    Cut,
    /// The tokens of an emulated vehicle have expired.
    Expire,
}

impl FaultKind {
    const NAMES: [(&'static str, Self); 14] = [
        ("stall", Self::Stall),
        ("drop", Self::Drop),
        ("delay", Self::Delay),
        ("duplicate", Self::Duplicate),
        ("corrupt", Self::Corrupt),
        ("disconnect", Self::Disconnect),
        ("reboot", Self::Reboot),
        ("panic", Self::Panic),
        ("suspend", Self::Suspend),
        ("takeover", Self::Takeover),
        ("silence", Self::Silence),
        ("hang", Self::Hang),
        ("cut", Self::Cut),
        ("expire", Self::Expire),
    ];

    fn from_name(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind)
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(_, kind)| kind == self).map_or("?", |(name, _)| name);
        f.write_str(name)
    }
}

/// One fault with its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// The kind.
    pub kind: FaultKind,
    /// Its start, counted from the program's start.
    pub start: Duration,
    /// Its duration; `None` for a fault without end. A fault that occurs once (panic, reboot) occurs at its
    /// start.
    pub duration: Option<Duration>,
}

/// The faults of one source or port. The empty plan has none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FaultPlan {
    faults: Vec<Fault>,
}

/// A fault in a plan that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FaultPlanError {
    /// The kind is unknown.
    #[error(
        "unknown fault `{0}`: use stall, drop, delay, duplicate, corrupt, disconnect, reboot, panic, suspend, takeover, silence, hang, cut or expire, as in `stall@12.5s`"
    )]
    UnknownKind(String),
    /// There is no `@`, or no number after it.
    #[error("fault `{0}` has no time: write KIND@SECONDS or KIND@SECONDS+DURATION, as in `drop@3+2`")]
    NoTime(String),
    /// The fault has no effect at this place.
    #[error("fault `{kind}` has no effect on {place}: there, use {known}")]
    NoEffect {
        /// The kind.
        kind: FaultKind,
        /// The place.
        place: String,
        /// The kinds that have an effect there.
        known: String,
    },
}

impl FaultPlan {
    /// Reads a plan, e.g. `stall@12.5s,drop@3+2`. An empty text is the empty plan.
    ///
    /// # Errors
    /// An unknown kind, or a time that is missing, negative or not a number.
    pub fn parse(text: &str) -> Result<Self, FaultPlanError> {
        let parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
        Ok(Self { faults: parts.map(parse_fault).collect::<Result<_, _>>()? })
    }

    /// Refuses the plan where a fault would have no effect at its place, where only the `known` kinds have
    /// one.
    ///
    /// # Errors
    /// The first such fault.
    pub fn require_effect(&self, place: &str, known: &[FaultKind]) -> Result<(), FaultPlanError> {
        match self.faults.iter().find(|fault| !known.contains(&fault.kind)) {
            None => Ok(()),
            Some(fault) => Err(FaultPlanError::NoEffect {
                kind: fault.kind,
                place: place.to_owned(),
                known: known.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "),
            }),
        }
    }

    /// Adds the faults of another plan.
    pub fn extend(&mut self, other: Self) {
        self.faults.extend(other.faults);
    }

    /// Whether the plan has no fault.
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// The faults, in the order of the text.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// Whether a fault of this kind is active at `at`.
    pub fn is_active(&self, kind: FaultKind, at: Timestamp) -> bool {
        let since_start = at.since(Timestamp::ZERO);
        self.faults.iter().filter(|fault| fault.kind == kind).any(|fault| {
            since_start >= fault.start
                && fault.duration.is_none_or(|duration| since_start < fault.start.saturating_add(duration))
        })
    }

    /// The number of faults of this kind that started after `after` and not later than `until`: for faults
    /// that occur once.
    pub fn count_started(&self, kind: FaultKind, after: Option<Timestamp>, until: Timestamp) -> usize {
        let has_started = |fault: &&Fault| {
            let at = Timestamp::ZERO.plus(fault.start);
            fault.kind == kind && at <= until && after.is_none_or(|after| at > after)
        };
        self.faults.iter().filter(has_started).count()
    }
}

impl fmt::Display for FaultPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.faults.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            write!(f, "{comma}{}@{}", fault.kind, fault.start.as_secs_f64())?;
            if let Some(duration) = fault.duration {
                write!(f, "+{}", duration.as_secs_f64())?;
            }
        }
        Ok(())
    }
}

fn parse_fault(text: &str) -> Result<Fault, FaultPlanError> {
    let (kind, times) = text.split_once('@').unwrap_or((text, ""));
    let kind = FaultKind::from_name(kind).ok_or_else(|| FaultPlanError::UnknownKind(kind.to_owned()))?;
    let (start, duration) = match times.split_once('+') {
        Some((start, duration)) => (start, Some(duration)),
        None => (times, None),
    };
    let no_time = || FaultPlanError::NoTime(text.to_owned());
    let start = parse_seconds(start).ok_or_else(no_time)?;
    let duration = duration.map(|duration| parse_seconds(duration).ok_or_else(no_time)).transpose()?;
    Ok(Fault { kind, start, duration })
}

fn parse_seconds(text: &str) -> Option<Duration> {
    let number: f64 = text.strip_suffix('s').unwrap_or(text).parse().ok()?;
    Duration::try_from_secs_f64(number).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_active(plan: &str, kind: FaultKind, seconds: f64, expected: bool) {
        let plan = FaultPlan::parse(plan).unwrap();
        assert_eq!(
            plan.is_active(kind, Timestamp::from_secs_f64(seconds)),
            expected,
            "{plan} at {seconds} s"
        );
    }

    #[test]
    fn a_fault_is_in_force_from_its_time_for_its_duration() {
        check_active("stall@12.5s", FaultKind::Stall, 12.4, false);
        check_active("stall@12.5s", FaultKind::Stall, 12.5, true);
        check_active("stall@12.5s", FaultKind::Stall, 1e6, true);
        check_active("drop@3+2", FaultKind::Drop, 2.9, false);
        check_active("drop@3+2", FaultKind::Drop, 3.0, true);
        check_active("drop@3s+2s", FaultKind::Drop, 4.9, true);
        check_active("drop@3+2", FaultKind::Drop, 5.0, false);
        check_active("drop@3+2", FaultKind::Stall, 4.0, false);
        check_active("stall@1+1,stall@3+1", FaultKind::Stall, 2.5, false);
        check_active("stall@1+1, stall@3+1", FaultKind::Stall, 3.5, true);
        check_active("", FaultKind::Panic, 0.0, false);
    }

    #[test]
    fn what_happens_once_is_counted_once() {
        let plan = FaultPlan::parse("reboot@0,reboot@2").unwrap();
        let at = Timestamp::from_secs_f64;
        assert_eq!(plan.count_started(FaultKind::Reboot, None, at(0.0)), 1);
        assert_eq!(plan.count_started(FaultKind::Reboot, Some(at(0.0)), at(1.0)), 0);
        assert_eq!(plan.count_started(FaultKind::Reboot, Some(at(1.0)), at(2.0)), 1);
    }

    #[test]
    fn a_fault_that_cannot_be_read_says_how_to_write_it() {
        for (text, named) in [
            ("explode@3", "explode"),
            ("stall", "stall"),
            ("stall@", "stall@"),
            ("stall@-1", "stall@-1"),
            ("stall@soon", "stall@soon"),
            ("drop@1+x", "drop@1+x"),
            ("stall@NaN", "stall@NaN"),
            ("stall@inf", "stall@inf"),
        ] {
            let error = FaultPlan::parse(text).unwrap_err().to_string();
            assert!(error.contains(named), "{text}: {error}");
        }
    }

    #[test]
    fn a_fault_without_effect_is_refused() {
        let plan = FaultPlan::parse("stall@1,corrupt@2").unwrap();
        assert_eq!(plan.require_effect("the link", &[FaultKind::Stall, FaultKind::Corrupt]), Ok(()));
        let said =
            plan.require_effect("the link", &[FaultKind::Stall, FaultKind::Drop]).unwrap_err().to_string();
        assert!(
            said.contains("`corrupt` has no effect on the link") && said.contains("stall, drop"),
            "{said}"
        );
    }

    #[test]
    fn a_plan_prints_as_it_is_read() {
        for text in ["stall@12.5,drop@3+2", "panic@0", "suspend@1+5,hang@2,cut@3,silence@4,takeover@5", ""] {
            assert_eq!(FaultPlan::parse(text).unwrap().to_string(), text);
        }
    }
}
