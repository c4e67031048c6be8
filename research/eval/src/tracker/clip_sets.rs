//! Which clips are judged together, which are of one recording, and where a label shows what cannot be seen.
//!
//! Clips of one recording, one flight or one site resemble each other. A mean over recordings counts each
//! recording once, with the mean of its clips.

use std::collections::BTreeMap;
use std::ops::Range;

use anyhow::{Context, Result};

use super::clips::ClipFolder;
use crate::statistics::mean;

/// The clips that the settings were tuned on, and clips that they were not tuned on: the names of the
/// folders.
pub(crate) const TUNED_ON: &str = "clips";
pub(crate) const UNSEEN: &str = "clips-more";

/// What the labelled objects are.
const CLASSES: &str = include_str!("../../data/clip_classes.csv");

/// The clips of [`TUNED_ON`] that show a boat or a person on water.
const TUNED_ON_WATER: [&str; 9] = [
    "raft_whitewater",
    "redboat_overhead",
    "stress_redboat_exit_reentry",
    "stress_redboat_glare_occl",
    "stress_redboat_shake_350k",
    "stress_redboat_small320",
    "uav123_boat1",
    "uav123_wakeboard7",
    "usv_view_ship",
];

/// The clip on water that shows neither a boat nor a person.
const SWAN: &str = "davis_blackswan";

/// Whether a clip shows a boat or a person on water.
pub(crate) fn is_on_water(clip: &str) -> bool {
    clip != SWAN && (UNSEEN_ON_WATER.contains(&clip) || TUNED_ON_WATER.contains(&clip))
}

/// The name of the set of all clips.
pub(crate) const ALL: &str = "all clips";

/// The clips of [`UNSEEN`] that show a target on water.
const UNSEEN_ON_WATER: [&str; 9] = [
    SWAN,
    "dtb70_surfing06",
    "hand_boat_waves",
    "hand_cruiseship_flyover",
    "hand_surfers_green",
    "hand_windsurfer",
    "uav123_boat5",
    "uav123_wakeboard3",
    "uav123_wakeboard4",
];

/// Prefixes of the names of clips that belong to one recording, flight or site, and its name.
const RECORDINGS: [(&str, &str); 4] = [
    ("stress_redboat_", "redboat_overhead"),
    ("uav123_group1_", "uav123_group1"),
    ("uav123_truck4_", "uav123_truck4"),
    ("uav123_wakeboard", "uav123_wakeboard"),
];

/// Clips with a label in frames in which more than half of the target is hidden, and those frames: here a bar
/// that was drawn over the boat.
const HIDDEN: [(&str, Range<usize>); 1] = [("stress_redboat_glare_occl", 101..119)];

/// The frames of a clip in which more than half of the target is hidden although it is labelled.
pub(crate) fn hidden_frames(clip: &str) -> Range<usize> {
    HIDDEN.iter().find(|(name, _)| *name == clip).map_or(0..0, |(_, frames)| frames.clone())
}

/// The recording that a clip belongs to.
pub(crate) fn recording_of(clip: &str) -> &str {
    RECORDINGS.iter().find(|(prefix, _)| clip.starts_with(prefix)).map_or(clip, |(_, recording)| recording)
}

/// Clips over which means are taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ClipSet {
    pub(crate) name: String,
    /// Names of the clips, in the order of the measurement.
    clips: Vec<String>,
}

impl ClipSet {
    fn new<'a>(name: &str, clips: impl Iterator<Item = &'a ClipFolder>) -> Self {
        Self { name: name.to_owned(), clips: clips.map(|clip| clip.name.clone()).collect() }
    }

    /// The number of clips.
    pub(crate) fn len(&self) -> usize {
        self.clips.len()
    }

    /// Whether a clip belongs to the set.
    pub(crate) fn contains(&self, clip: &str) -> bool {
        self.clips.iter().any(|name| name == clip)
    }
}

/// The sets of these clips that are not empty: each folder, the unseen clips on water, and, of several
/// folders, all.
pub(crate) fn clip_sets(clips: &[ClipFolder]) -> Vec<ClipSet> {
    let mut collections: Vec<&str> = clips.iter().map(|clip| clip.collection.as_str()).collect();
    collections.dedup();
    let mut sets = Vec::new();
    for &collection in &collections {
        let members = || clips.iter().filter(|clip| clip.collection == collection);
        sets.push(ClipSet::new(collection, members()));
        if collection == UNSEEN {
            let on_water = members().filter(|clip| UNSEEN_ON_WATER.contains(&clip.name.as_str()));
            sets.push(ClipSet::new(&format!("{UNSEEN}, on water"), on_water));
        }
    }
    if collections.len() > 1 {
        sets.push(ClipSet::new(ALL, clips.iter()));
    }
    sets.retain(|set| !set.clips.is_empty());
    sets
}

/// The means of a figure over clips, and over recordings; NaN of no clips.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SetMean {
    pub(crate) over_clips: f64,
    pub(crate) over_recordings: f64,
}

/// The means of a figure of each clip, given with the clip's name.
pub(crate) fn set_mean<'a>(figures: impl Iterator<Item = (&'a str, f64)>) -> SetMean {
    let mut by_recording: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut all = Vec::new();
    for (clip, figure) in figures {
        all.push(figure);
        by_recording.entry(recording_of(clip)).or_default().push(figure);
    }
    let of_recordings: Vec<f64> = by_recording.values().map(|figures| mean(figures)).collect();
    SetMean { over_clips: mean(&all), over_recordings: mean(&of_recordings) }
}

/// The number of recordings among clips.
pub(crate) fn count_recordings<'a>(clips: impl Iterator<Item = &'a str>) -> usize {
    clips.map(recording_of).collect::<std::collections::BTreeSet<_>>().len()
}

/// What the labelled object of a clip is: `boat`, `person` or `other`.
///
/// # Errors
/// If the clip is not in the list.
pub(crate) fn class_of(clip: &str) -> Result<&'static str> {
    let row = CLASSES.lines().filter_map(|line| line.split_once(',')).find(|(name, _)| *name == clip);
    Ok(row.with_context(|| format!("{clip} is not in research/eval/data/clip_classes.csv"))?.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_have_a_class() {
        assert_eq!(class_of("raft_whitewater").unwrap(), "boat");
        assert!(class_of("none").is_err());
        let classes = CLASSES.lines().skip(1).map(|line| line.split_once(',').unwrap().1);
        assert!(classes.into_iter().all(|class| ["person", "boat", "other"].contains(&class)));
    }

    #[test]
    fn clips_of_one_recording_belong_to_it() {
        for (clip, recording) in [
            ("stress_redboat_small320", "redboat_overhead"),
            ("redboat_overhead", "redboat_overhead"),
            ("uav123_group1_4", "uav123_group1"),
            ("uav123_group3_2", "uav123_group3_2"),
            ("uav123_truck4_2", "uav123_truck4"),
            ("uav123_wakeboard7", "uav123_wakeboard"),
            ("orange_taxi", "orange_taxi"),
        ] {
            assert_eq!(recording_of(clip), recording);
        }
    }

    #[test]
    fn a_recording_counts_once_however_many_clips_it_has() {
        let figures = [("stress_redboat_a", 0.2), ("redboat_overhead", 0.4), ("orange_taxi", 0.9)];
        let means = set_mean(figures.into_iter());
        // Rounded sums.
        assert!((means.over_clips - 0.5).abs() < 1e-12 && (means.over_recordings - 0.6).abs() < 1e-12);
        assert_eq!(count_recordings(figures.iter().map(|(clip, _)| *clip)), 2);
    }

    #[test]
    fn sets_are_folders_the_unseen_on_water_and_all() {
        let clips = [
            ClipFolder::for_test("orange_taxi", TUNED_ON),
            ClipFolder::for_test("uav123_boat5", UNSEEN),
            ClipFolder::for_test("otb_bolt", UNSEEN),
        ];
        let sizes = |clips: &[ClipFolder]| {
            clip_sets(clips).iter().map(|set| (set.name.clone(), set.len())).collect::<Vec<_>>()
        };
        let set = |name: &str, clips: usize| (name.to_owned(), clips);
        assert_eq!(
            sizes(&clips),
            [set("clips", 1), set("clips-more", 2), set("clips-more, on water", 1), set("all clips", 3)]
        );
        assert_eq!(sizes(&clips[..1]), [set("clips", 1)]);
        assert!(clip_sets(&clips)[2].contains("uav123_boat5"));
    }
}
