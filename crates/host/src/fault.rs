//! Faults on purpose: what is to go wrong, and when.
//!
//! A plan is written `KIND@SECONDS[+DURATION]`, several with commas: `stall@12.5s,drop@3+2` stalls from 12.5 s
//! on for ever and drops what comes between 3 s and 5 s. All times count from the program's start. Every port and video source takes one, so that tests,
//! the simulator and the bench break things in the same way. The plan only says *whether* a fault is in force
//! at a time; what a kind does to packets or video units is written where they pass.

use std::fmt;
use std::time::Duration;

use barrelman_vocab::time::Timestamp;

/// A way to go wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum FaultKind {
    /// Nothing comes any more, and no error either, as when the tether is pulled.
    Stall,
    /// What comes is thrown away.
    Drop,
    /// What comes is held back and handed over late.
    Delay,
    /// What comes is handed over twice.
    Duplicate,
    /// Some bytes of what comes are changed.
    Corrupt,
    /// The connection breaks, and cannot be made again while the fault lasts.
    Disconnect,
    /// An emulated vehicle starts afresh.
    Reboot,
    /// The thread panics, to test that everything stops.
    Panic,
}

impl FaultKind {
    const NAMES: [(&'static str, Self); 8] = [
        ("stall", Self::Stall),
        ("drop", Self::Drop),
        ("delay", Self::Delay),
        ("duplicate", Self::Duplicate),
        ("corrupt", Self::Corrupt),
        ("disconnect", Self::Disconnect),
        ("reboot", Self::Reboot),
        ("panic", Self::Panic),
    ];

    fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(known, _)| *known == name).map(|(_, kind)| *kind)
    }
}

impl fmt::Display for FaultKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(_, kind)| kind == self).map_or("?", |(name, _)| name);
        f.write_str(name)
    }
}

/// One fault with its time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// What goes wrong.
    pub kind: FaultKind,
    /// When it begins, counted from the program's start.
    pub from: Duration,
    /// How long it lasts; `None`: for ever. What happens once (a panic, a reboot) happens at the beginning.
    pub lasts: Option<Duration>,
}

/// All faults of one source or port. The empty plan lets everything pass.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FaultPlan {
    faults: Vec<Fault>,
}

/// A fault that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FaultPlanError {
    /// The kind is unknown.
    #[error(
        "unknown fault `{0}`: use stall, drop, delay, duplicate, corrupt, disconnect, reboot or panic, as in `stall@12.5s`"
    )]
    UnknownKind(String),
    /// There is no `@`, or no number behind it.
    #[error("fault `{0}` has no time: write KIND@SECONDS or KIND@SECONDS+DURATION, as in `drop@3+2`")]
    NoTime(String),
}

impl FaultPlan {
    /// Reads a plan, e.g. `stall@12.5s,drop@3+2`. An empty text is the empty plan.
    ///
    /// # Errors
    /// A kind that is unknown, or a time that is missing, negative or not a number.
    pub fn parse(text: &str) -> Result<Self, FaultPlanError> {
        let parts = text.split(',').map(str::trim).filter(|part| !part.is_empty());
        Ok(Self { faults: parts.map(parse_fault).collect::<Result<_, _>>()? })
    }

    /// Whether nothing goes wrong at all.
    pub fn is_empty(&self) -> bool {
        self.faults.is_empty()
    }

    /// The faults, in the order written.
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// Whether a fault of that kind is in force at `at`, counted from the program's start.
    pub fn active(&self, kind: FaultKind, at: Timestamp) -> bool {
        let since_start = at.since(Timestamp::ZERO);
        self.faults.iter().filter(|fault| fault.kind == kind).any(|fault| {
            since_start >= fault.from && fault.lasts.is_none_or(|lasts| since_start < fault.from + lasts)
        })
    }

    /// How many faults of that kind began after `after` and not later than `until`: for what happens once.
    pub fn begun(&self, kind: FaultKind, after: Option<Timestamp>, until: Timestamp) -> usize {
        let began = |fault: &&Fault| {
            let at = Timestamp::ZERO.plus(fault.from);
            fault.kind == kind && at <= until && after.is_none_or(|after| at > after)
        };
        self.faults.iter().filter(began).count()
    }
}

impl fmt::Display for FaultPlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, fault) in self.faults.iter().enumerate() {
            let comma = if index == 0 { "" } else { "," };
            write!(f, "{comma}{}@{}", fault.kind, fault.from.as_secs_f64())?;
            if let Some(lasts) = fault.lasts {
                write!(f, "+{}", lasts.as_secs_f64())?;
            }
        }
        Ok(())
    }
}

fn parse_fault(text: &str) -> Result<Fault, FaultPlanError> {
    let (kind, times) = text.split_once('@').unwrap_or((text, ""));
    let kind = FaultKind::named(kind).ok_or_else(|| FaultPlanError::UnknownKind(kind.to_owned()))?;
    let (from, lasts) = match times.split_once('+') {
        Some((from, lasts)) => (from, Some(lasts)),
        None => (times, None),
    };
    let no_time = || FaultPlanError::NoTime(text.to_owned());
    let from = parse_seconds(from).ok_or_else(no_time)?;
    let lasts = lasts.map(|lasts| parse_seconds(lasts).ok_or_else(no_time)).transpose()?;
    Ok(Fault { kind, from, lasts })
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
        assert_eq!(plan.active(kind, Timestamp::from_secs_f64(seconds)), expected, "{plan} at {seconds} s");
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
        assert_eq!(plan.begun(FaultKind::Reboot, None, at(0.0)), 1);
        assert_eq!(plan.begun(FaultKind::Reboot, Some(at(0.0)), at(1.0)), 0);
        assert_eq!(plan.begun(FaultKind::Reboot, Some(at(1.0)), at(2.0)), 1);
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
    fn a_plan_prints_as_it_is_read() {
        for text in ["stall@12.5,drop@3+2", "panic@0", ""] {
            assert_eq!(FaultPlan::parse(text).unwrap().to_string(), text);
        }
    }
}
