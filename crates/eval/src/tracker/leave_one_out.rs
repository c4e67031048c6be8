//! How well settings that were chosen on other recordings do on one that they have not seen.
//!
//! For each recording in turn, coordinate descent over the thresholds of [`CANDIDATES`] looks for the settings with
//! the largest mean AUC over all other recordings; these are then scored on the one left out. The clips of one
//! recording stay together, and a recording counts as the mean of its clips.
//!
//! All clips are decoded into memory once, every pair of clip and settings is run once however many recordings ask
//! for it, and two threads share the work: nothing is timed here.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, ensure};
use serde_json::{Value, json};

use super::Options;
use super::candidates::CANDIDATES;
use super::clips::Clip;
use super::figures::mean;
use super::follow::follow;
use super::parallel;
use super::report::{Table, cell};
use super::under_test::{self, Config};
use crate::say;

/// Rounds over all thresholds; fewer where a round changes nothing.
const PASSES: usize = 2;

/// An AUC must be larger by this to be better: sums in another order are none.
const BETTER_BY: f64 = 1e-9;

/// The recording that these clips were made from.
const DERIVED_FROM: (&str, &str) = ("stress_redboat_", "redboat_overhead");

/// The recording that a clip is of.
fn recording_of(clip: &str) -> &str {
    if clip.starts_with(DERIVED_FROM.0) { DERIVED_FROM.1 } else { clip }
}

/// For each threshold, which of its candidates is taken; none for the default.
type Choice = Vec<Option<usize>>;

/// Chooses and scores settings for each recording, prints the table, and returns the figures.
///
/// # Errors
/// If a clip cannot be used, or the tracker refuses a candidate.
pub(crate) fn run(options: &Options, base: &Config) -> Result<Value> {
    let clips: Vec<Clip> =
        options.clip_folders()?.iter().map(|folder| folder.load()).collect::<Result<_>>()?;
    let recordings: BTreeSet<&str> = clips.iter().map(|clip| recording_of(&clip.name)).collect();
    ensure!(recordings.len() > 1, "one recording has no others to choose settings on");
    let mut runs = Runs { base, clips: &clips, aucs: BTreeMap::new() };
    let mut choices: BTreeMap<&str, Choice> =
        recordings.iter().map(|&recording| (recording, vec![None; CANDIDATES.len()])).collect();
    for pass in 1..=PASSES {
        let before = choices.clone();
        for (threshold, candidate) in CANDIDATES.iter().enumerate() {
            choose(&mut runs, &mut choices, threshold)?;
            say(&format!("pass {pass}, {}: {} runs of a clip so far", candidate.name, runs.aucs.len()));
        }
        if choices == before {
            break;
        }
    }
    Ok(say_table(&runs, &choices))
}

/// Takes for each recording the candidate of one threshold that is best on the others.
fn choose(runs: &mut Runs<'_>, choices: &mut BTreeMap<&str, Choice>, threshold: usize) -> Result<()> {
    let variants = |choice: &Choice| -> Vec<Choice> {
        let mut variants = vec![choice.clone()];
        for value in 0..CANDIDATES[threshold].values.len() {
            let mut variant = choice.clone();
            variant[threshold] = Some(value);
            variants.push(variant);
        }
        variants
    };
    let needed: BTreeSet<Choice> = choices.values().flat_map(variants).collect();
    runs.make(&needed.into_iter().collect::<Vec<_>>())?;
    for (&left_out, choice) in choices.iter_mut() {
        let mut best = runs.mean_auc(choice, |recording| recording != left_out);
        for variant in variants(choice) {
            let auc = runs.mean_auc(&variant, |recording| recording != left_out);
            if auc > best + BETTER_BY {
                best = auc;
                *choice = variant;
            }
        }
    }
    Ok(())
}

fn say_table(runs: &Runs<'_>, choices: &BTreeMap<&str, Choice>) -> Value {
    let mut headings = vec!["left out"];
    headings.extend(CANDIDATES.iter().map(|candidate| candidate.name));
    headings.extend(["AUC default", "AUC chosen", "others default", "others chosen"]);
    let mut table = Table::new(&headings);
    let default: Choice = vec![None; CANDIDATES.len()];
    let mut rows = Vec::new();
    let mut json = Vec::new();
    for (&left_out, choice) in choices {
        let aucs = [&default, choice].map(|choice| {
            (
                runs.mean_auc(choice, |recording| recording == left_out),
                runs.mean_auc(choice, |recording| recording != left_out),
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
            CANDIDATES.iter().map(|candidate| candidate.name).zip(chosen).collect();
        json.push(json!({
            "left_out": left_out, "chosen": named, "auc_default": row[0], "auc_chosen": row[1],
            "others_auc_default": row[2], "others_auc_chosen": row[3],
        }));
    }
    let mut cells = vec!["mean over recordings".to_owned()];
    cells.extend(CANDIDATES.iter().map(|_| String::new()));
    cells.extend((0..4).map(|column| cell(mean(&rows.iter().map(|row| row[column]).collect::<Vec<_>>()), 3)));
    table.row(cells);
    let clip_mean = |of: &dyn Fn(&Clip) -> f64| mean(&runs.clips.iter().map(of).collect::<Vec<_>>());
    let by_default = clip_mean(&|clip| runs.auc(&default, clip));
    let by_choice = clip_mean(&|clip| {
        choices.get(recording_of(&clip.name)).map_or(f64::NAN, |choice| runs.auc(choice, clip))
    });
    let mut cells = vec!["mean over clips".to_owned()];
    cells.extend(CANDIDATES.iter().map(|_| String::new()));
    cells.extend([cell(by_default, 3), cell(by_choice, 3), "-".to_owned(), "-".to_owned()]);
    table.row(cells);
    table.say("Settings chosen on the other recordings (a dash: the default)");
    json!({ "recordings": json, "clip_mean_auc_default": by_default, "clip_mean_auc_chosen": by_choice })
}

/// The chosen value of each threshold; none for the default.
fn values(choice: &Choice) -> Vec<Option<f64>> {
    CANDIDATES
        .iter()
        .zip(choice)
        .map(|(candidate, index)| index.map(|index| candidate.values[index]))
        .collect()
}

/// AUCs of pairs of clip and settings.
struct Runs<'a> {
    base: &'a Config,
    clips: &'a [Clip],
    /// By the settings, written out, and the clip's name.
    aucs: BTreeMap<(String, String), f64>,
}

impl Runs<'_> {
    fn config(&self, choice: &Choice) -> Config {
        let mut config = Config::clone(self.base);
        for (candidate, value) in CANDIDATES.iter().zip(values(choice)) {
            if let Some(value) = value {
                (candidate.set)(&mut config, value);
            }
        }
        config
    }

    /// Two choices with the same settings have the same key.
    fn key(&self, choice: &Choice, clip: &Clip) -> (String, String) {
        (format!("{:?}", self.config(choice)), clip.name.clone())
    }

    /// Runs what was not run before: all clips with each of these.
    fn make(&mut self, choices: &[Choice]) -> Result<()> {
        let mut jobs = BTreeMap::new();
        for choice in choices {
            let config = self.config(choice);
            under_test::make(&config)?;
            for clip in self.clips {
                let key = self.key(choice, clip);
                if !self.aucs.contains_key(&key) {
                    jobs.insert(key, (Config::clone(&config), clip));
                }
            }
        }
        let jobs: Vec<_> = jobs.into_iter().collect();
        let aucs = parallel::map(&jobs, |(_, (config, clip))| {
            let mut tracker = under_test::make(config)?;
            anyhow::Ok(follow(tracker.as_mut(), clip, clip.selection).score(clip).auc)
        });
        for ((key, _), auc) in jobs.into_iter().zip(aucs) {
            self.aucs.insert(key, auc?);
        }
        Ok(())
    }

    /// That of a pair that was run; not a number of any other.
    fn auc(&self, choice: &Choice, clip: &Clip) -> f64 {
        self.aucs.get(&self.key(choice, clip)).copied().unwrap_or(f64::NAN)
    }

    /// Mean over recordings of the mean over their clips.
    fn mean_auc(&self, choice: &Choice, which: impl Fn(&str) -> bool) -> f64 {
        let mut by_recording: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
        for clip in self.clips {
            let recording = recording_of(&clip.name);
            if which(recording) {
                by_recording.entry(recording).or_default().push(self.auc(choice, clip));
            }
        }
        mean(&by_recording.values().map(|aucs| mean(aucs)).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clips_made_from_one_recording_belong_to_it() {
        assert_eq!(recording_of("stress_redboat_small320"), "redboat_overhead");
        assert_eq!(recording_of("redboat_overhead"), "redboat_overhead");
        assert_eq!(recording_of("orange_taxi"), "orange_taxi");
    }

    #[test]
    fn a_recording_counts_once_however_many_clips_it_has() {
        let (a, b, c) = (clip("stress_redboat_a"), clip("redboat_overhead"), clip("orange_taxi"));
        let clips = [a, b, c];
        let base = Config::default();
        let choice: Choice = vec![None; CANDIDATES.len()];
        let mut runs = Runs { base: &base, clips: &clips, aucs: BTreeMap::new() };
        for (clip, auc) in clips.iter().zip([0.2, 0.4, 0.9]) {
            let key = runs.key(&choice, clip);
            runs.aucs.insert(key, auc);
        }
        // Rounded sums.
        assert!((runs.mean_auc(&choice, |_| true) - 0.6).abs() < 1e-12);
        assert!((runs.mean_auc(&choice, |recording| recording != "orange_taxi") - 0.3).abs() < 1e-12);
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
