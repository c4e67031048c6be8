//! Behaviour versions of the tracker and the law that made a file.
//!
//! `barrelman_vision::behaviour` and `barrelman_control::behaviour` hold the versions of this program, and the rule
//! when to raise them.

/// The version that a file was made with which states none: such files are older than the versions.
pub const FIRST: u32 = 1;

/// The versions of a tracker and a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BehaviourVersions {
    /// Of the tracker.
    pub tracker: u32,
    /// Of the law.
    pub law: u32,
}

/// The versions of a file that states none.
impl Default for BehaviourVersions {
    fn default() -> Self {
        Self { tracker: FIRST, law: FIRST }
    }
}

/// What two sets of versions differ in, in words.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VersionDifference {
    /// The first set: "the fused tracker's behaviour 1".
    pub first: String,
    /// The second set, in the same order: "2".
    pub second: String,
}

impl BehaviourVersions {
    /// What these versions and `other` differ in, for a tracker and a law of these names; `None` where they are the
    /// same.
    pub fn difference(self, other: Self, tracker: &str, law: &str) -> Option<VersionDifference> {
        let differing: Vec<(String, u32, u32)> = [
            (format!("the {tracker} tracker's behaviour"), self.tracker, other.tracker),
            (format!("the {law} law's behaviour"), self.law, other.law),
        ]
        .into_iter()
        .filter(|(_, first, second)| first != second)
        .collect();
        let joined = |parts: Vec<String>| parts.join(" and ");
        (!differing.is_empty()).then(|| VersionDifference {
            first: joined(differing.iter().map(|(name, first, _)| format!("{name} {first}")).collect()),
            second: joined(differing.iter().map(|(_, _, second)| second.to_string()).collect()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(tracker: u32, law: u32, expected: Option<(&str, &str)>) {
        let difference =
            BehaviourVersions::default().difference(BehaviourVersions { tracker, law }, "fused", "optimal");
        let words = difference.as_ref().map(|found| (found.first.as_str(), found.second.as_str()));
        assert_eq!(words, expected);
    }

    #[test]
    fn a_difference_names_what_differs_alone() {
        check(1, 1, None);
        check(2, 1, Some(("the fused tracker's behaviour 1", "2")));
        check(1, 3, Some(("the optimal law's behaviour 1", "3")));
        check(2, 3, Some(("the fused tracker's behaviour 1 and the optimal law's behaviour 1", "2 and 3")));
    }
}
