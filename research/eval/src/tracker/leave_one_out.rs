//! Leave-one-out cross-validation of the tuned settings, on labelled real clips.
//!
//! For each recording, coordinate descent over [`TUNED_SETTINGS`] searches for the settings with the largest
//! mean AUC over all other recordings, and these settings are scored on the recording that was left out. All
//! clips made from one recording belong together; a recording counts as the mean of its clips. Nothing is
//! judged.
//!
//! All clips are decoded into memory once. Every pair of clip and settings is run once, on two threads,
//! because nothing is timed.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, ensure};
use serde_json::{Value, json};

use super::clip_sets::{recording_of, set_mean};
use super::clips::Clip;
use super::options::Options;
use super::text_table::{Table, cell};
use super::tracker_run::run_tracker;
use super::tracker_under_test::{TrackerConfig, build_tracker};
use super::tuned_settings::TUNED_SETTINGS;
use crate::output::print_line;
use crate::parallel;
use crate::statistics::mean;

/// Passes over all settings; fewer where a pass changes nothing.
const MAX_PASSES: usize = 2;

/// A better AUC is larger by at least this, more than the rounding of sums.
const MIN_IMPROVEMENT: f64 = 1e-9;

/// For each setting, the index of the chosen value; `None` for the default.
type Choice = Vec<Option<usize>>;

/// Chooses and scores settings for each recording, prints the table, and returns the figures.
///
/// # Errors
/// If a clip cannot be used, or the tracker refuses a value.
pub(crate) fn run(options: &Options, base: &TrackerConfig) -> Result<Value> {
    let clips: Vec<Clip> =
        options.clip_folders()?.iter().map(|folder| folder.load()).collect::<Result<_>>()?;
    let recordings: BTreeSet<&str> = clips.iter().map(|clip| recording_of(&clip.name)).collect();
    ensure!(recordings.len() > 1, "leave-one-out needs clips of at least two recordings");
    let mut cache = AucCache { base, clips: &clips, aucs: BTreeMap::new() };
    let mut choices: BTreeMap<&str, Choice> =
        recordings.iter().map(|&recording| (recording, vec![None; TUNED_SETTINGS.len()])).collect();
    for pass in 1..=MAX_PASSES {
        let before = choices.clone();
        for (index, setting) in TUNED_SETTINGS.iter().enumerate() {
            choose_value(&mut cache, &mut choices, index)?;
            print_line(&format!("pass {pass}, {}: {} runs of a clip so far", setting.name, cache.aucs.len()));
        }
        if choices == before {
            break;
        }
    }
    Ok(print_table(&cache, &choices))
}

/// Chooses for each recording the value of one setting that is best on the others.
fn choose_value(
    cache: &mut AucCache<'_>,
    choices: &mut BTreeMap<&str, Choice>,
    setting: usize,
) -> Result<()> {
    let variants = |choice: &Choice| -> Vec<Choice> {
        let mut variants = vec![choice.clone()];
        for value in 0..TUNED_SETTINGS[setting].values.len() {
            let mut variant = choice.clone();
            variant[setting] = Some(value);
            variants.push(variant);
        }
        variants
    };
    let needed: BTreeSet<Choice> = choices.values().flat_map(variants).collect();
    cache.fill(&needed.into_iter().collect::<Vec<_>>())?;
    for (&left_out, choice) in choices.iter_mut() {
        let mut best = cache.mean_auc(choice, |recording| recording != left_out);
        for variant in variants(choice) {
            let auc = cache.mean_auc(&variant, |recording| recording != left_out);
            if auc > best + MIN_IMPROVEMENT {
                best = auc;
                *choice = variant;
            }
        }
    }
    Ok(())
}

/// Prints the settings of each recording with the AUCs, and returns the figures.
fn print_table(cache: &AucCache<'_>, choices: &BTreeMap<&str, Choice>) -> Value {
    let mut headings = vec!["left out"];
    headings.extend(TUNED_SETTINGS.iter().map(|setting| setting.name));
    headings.extend(["AUC default", "AUC chosen", "others default", "others chosen"]);
    let mut table = Table::new(&headings);
    let default: Choice = vec![None; TUNED_SETTINGS.len()];
    let mut rows = Vec::new();
    let mut json = Vec::new();
    for (&left_out, choice) in choices {
        let aucs = [&default, choice].map(|choice| {
            (
                cache.mean_auc(choice, |recording| recording == left_out),
                cache.mean_auc(choice, |recording| recording != left_out),
            )
        });
        let row = [aucs[0].0, aucs[1].0, aucs[0].1, aucs[1].1];
        let chosen = values(choice);
        let mut cells = vec![left_out.to_owned()];
        cells.extend(chosen.iter().map(|value| value.map_or("-".to_owned(), |value| value.to_string())));
        cells.extend(row.iter().map(|auc| cell(*auc, 3)));
        table.row(cells);
        rows.push(row);
        let named: BTreeMap<&str, Option<f64>> =
            TUNED_SETTINGS.iter().map(|setting| setting.name).zip(chosen).collect();
        json.push(json!({
            "left_out": left_out, "chosen": named, "auc_default": row[0], "auc_chosen": row[1],
            "others_auc_default": row[2], "others_auc_chosen": row[3],
        }));
    }
    let mut cells = vec!["mean over recordings".to_owned()];
    cells.extend(TUNED_SETTINGS.iter().map(|_| String::new()));
    cells.extend((0..4).map(|column| cell(mean(&rows.iter().map(|row| row[column]).collect::<Vec<_>>()), 3)));
    table.row(cells);
    let clip_mean = |of: &dyn Fn(&Clip) -> f64| mean(&cache.clips.iter().map(of).collect::<Vec<_>>());
    let by_default = clip_mean(&|clip| cache.auc(&default, clip));
    let by_choice = clip_mean(&|clip| {
        choices.get(recording_of(&clip.name)).map_or(f64::NAN, |choice| cache.auc(choice, clip))
    });
    let mut cells = vec!["mean over clips".to_owned()];
    cells.extend(TUNED_SETTINGS.iter().map(|_| String::new()));
    cells.extend([cell(by_default, 3), cell(by_choice, 3), "-".to_owned(), "-".to_owned()]);
    table.row(cells);
    table.print("Settings chosen on the other recordings (a dash: the default)");
    json!({ "recordings": json, "clip_mean_auc_default": by_default, "clip_mean_auc_chosen": by_choice })
}

/// The chosen value of each setting; `None` for the default.
fn values(choice: &Choice) -> Vec<Option<f64>> {
    TUNED_SETTINGS
        .iter()
        .zip(choice)
        .map(|(setting, index)| index.map(|index| setting.values[index]))
        .collect()
}

/// The AUC of each pair of clip and settings that was run.
struct AucCache<'a> {
    /// The settings without any choice.
    base: &'a TrackerConfig,
    clips: &'a [Clip],
    /// By the settings' debug text and the clip's name.
    aucs: BTreeMap<(String, String), f64>,
}

impl AucCache<'_> {
    fn config(&self, choice: &Choice) -> TrackerConfig {
        let mut config = TrackerConfig::clone(self.base);
        for (setting, value) in TUNED_SETTINGS.iter().zip(values(choice)) {
            if let Some(value) = value {
                setting.set(&mut config, value);
            }
        }
        config
    }

    /// The key of a pair. Choices that result in the same settings have the same key.
    fn key(&self, choice: &Choice, clip: &Clip) -> (String, String) {
        (format!("{:?}", self.config(choice)), clip.name.clone())
    }

    /// Runs all clips with each of these choices, except pairs that were run before.
    fn fill(&mut self, choices: &[Choice]) -> Result<()> {
        let mut jobs = BTreeMap::new();
        for choice in choices {
            let config = self.config(choice);
            build_tracker(&config)?;
            for clip in self.clips {
                let key = self.key(choice, clip);
                if !self.aucs.contains_key(&key) {
                    jobs.insert(key, (TrackerConfig::clone(&config), clip));
                }
            }
        }
        let jobs: Vec<_> = jobs.into_iter().collect();
        let aucs = parallel::map(&jobs, |(_, (config, clip))| {
            let mut tracker = build_tracker(config)?;
            anyhow::Ok(run_tracker(tracker.as_mut(), clip, clip.selection).score(clip).auc)
        });
        for ((key, _), auc) in jobs.into_iter().zip(aucs) {
            self.aucs.insert(key, auc?);
        }
        Ok(())
    }

    /// The AUC of a pair; NaN where the pair was not run.
    fn auc(&self, choice: &Choice, clip: &Clip) -> f64 {
        self.aucs.get(&self.key(choice, clip)).copied().unwrap_or(f64::NAN)
    }

    /// The mean over the recordings that `includes` accepts of the mean over their clips.
    fn mean_auc(&self, choice: &Choice, includes: impl Fn(&str) -> bool) -> f64 {
        let clips = self.clips.iter().map(|clip| (clip.name.as_str(), clip));
        let included = clips.filter(|(name, _)| includes(recording_of(name)));
        set_mean(included.map(|(name, clip)| (name, self.auc(choice, clip)))).over_recordings
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_counts_once_however_many_clips_it_has() {
        let (a, b, c) = (clip("stress_redboat_a"), clip("redboat_overhead"), clip("orange_taxi"));
        let clips = [a, b, c];
        let base = TrackerConfig::default();
        let choice: Choice = vec![None; TUNED_SETTINGS.len()];
        let mut cache = AucCache { base: &base, clips: &clips, aucs: BTreeMap::new() };
        for (clip, auc) in clips.iter().zip([0.2, 0.4, 0.9]) {
            let key = cache.key(&choice, clip);
            cache.aucs.insert(key, auc);
        }
        // Rounded sums.
        assert!((cache.mean_auc(&choice, |_| true) - 0.6).abs() < 1e-12);
        assert!((cache.mean_auc(&choice, |recording| recording != "orange_taxi") - 0.3).abs() < 1e-12);
    }

    fn clip(name: &str) -> Clip {
        Clip {
            name: name.to_owned(),
            frames: Vec::new(),
            labels: Vec::new(),
            start: 0,
            selection: barrelman_vocab::PixelBox::default(),
        }
    }
}
