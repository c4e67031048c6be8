//! The table of clips: how well the tracker follows on each, and what it costs.

use anyhow::Result;
use barrelman_vision::SelectionError;
use barrelman_vocab::PictureSize;
use serde_json::{Value, json};

use super::Options;
use super::clips::{Clip, ClipFolder};
use super::figures::{Spread, mean};
use super::follow::{Followed, confidence_of, corners, follow, state_of};
use super::jitter;
use super::opencv::{self, OpenCv};
use super::reliability::{self, Sample};
use super::report::{Requirements, Table, cell};
use super::scoring::{Label, Score, overlap};
use super::under_test::{self, Config, Factory};
use super::upscale;
use crate::say;

/// The size that the limits of cost are given for.
const HD: PictureSize = PictureSize::new(1280, 720);

const AUC_WANTED: f64 = 0.72;
const PRECISION_WANTED: f64 = 0.93;
const LOST_WANTED: f64 = 0.04;
/// A small lead of another tracker on a clip is no fault; falling behind it by more than this share is.
const SHARE_OF_CSRT_WANTED: f64 = 0.8;
const TIMES_CHEAPER_WANTED: f64 = 20.0;
const MEDIAN_MS_WANTED: f64 = 1.0;
const P99_MS_WANTED: f64 = 3.0;
const UPSCALED_MEDIAN_MS_WANTED: f64 = 1.5;

/// What was measured on one clip.
struct Measured {
    name: String,
    size: PictureSize,
    score: Score,
    cpu_ms: Vec<f64>,
    refused: Option<SelectionError>,
    samples: Vec<Sample>,
    csrt: Option<opencv::Result>,
    jittered: Option<Vec<Score>>,
    upscaled: Option<(Score, Vec<f64>)>,
    frames: Value,
}

/// Measures all clips, prints the tables, judges the requirements, and returns the figures.
///
/// # Errors
/// If a clip or OpenCV cannot be used.
pub(crate) fn run(options: &Options, config: &Config, requirements: &mut Requirements) -> Result<Value> {
    // Settings out of range are found before anything is decoded.
    under_test::make(config)?;
    #[allow(clippy::expect_used, reason = "the same settings were accepted above")]
    let factory = || under_test::make(config).expect("settings that were accepted once are accepted again");
    let mut opencv = options.csrt.then(|| OpenCv::start(&options.python()?)).transpose()?;
    let mut all = Vec::new();
    for folder in options.clip_folders()? {
        all.push(measure(options, &folder, &factory, opencv.as_mut())?);
    }
    if let Some(opencv) = opencv {
        opencv.end()?;
    }
    say_table(&all);
    if options.csrt {
        say_beside_csrt(&all);
    }
    if options.jitter {
        jitter::say_table(all.iter().filter_map(|clip| {
            clip.jittered.as_ref().map(|scores| (clip.name.as_str(), clip.score.auc, scores.as_slice()))
        }));
    }
    if options.upscaled {
        say_upscaled(&all);
    }
    let samples: Vec<Sample> = all.iter().flat_map(|clip| clip.samples.iter().copied()).collect();
    let curve = reliability::curve(&samples);
    reliability::say_table(&curve);
    let whole = options.clip.is_empty();
    say("");
    judge(options, whole, &all, requirements);
    if whole {
        reliability::judge(&curve, requirements);
    } else {
        say("        not judged on a selection of clips: the means over all of them, and the confidence");
    }
    reliability::draw(&curve)?;
    Ok(Value::Array(all.into_iter().map(to_json).collect()))
}

fn measure(
    options: &Options,
    folder: &ClipFolder,
    factory: Factory<'_>,
    opencv: Option<&mut OpenCv>,
) -> Result<Measured> {
    let clip = folder.load()?;
    let followed = follow(factory().as_mut(), &clip, clip.selection);
    let csrt = opencv.map(|opencv| opencv.follow(folder, &clip)).transpose()?;
    let jittered = options.jitter.then(|| jitter::scores(factory, &clip));
    let upscaled = (options.upscaled && clip.size() == HD).then(|| {
        let clip = upscale::enlarged(&clip);
        let followed = follow(factory().as_mut(), &clip, clip.selection);
        (followed.score(&clip), followed.cpu_ms())
    });
    Ok(Measured {
        name: clip.name.clone(),
        size: clip.size(),
        score: followed.score(&clip),
        cpu_ms: followed.cpu_ms(),
        refused: followed.refused,
        samples: reliability::samples(&clip, &followed),
        csrt,
        jittered,
        upscaled,
        frames: frames_json(&clip, &followed),
    })
}

fn say_table(all: &[Measured]) {
    let mut table = Table::new(&[
        "clip",
        "size",
        "scored",
        "AUC",
        "P20",
        "lost",
        "absent",
        "reported",
        "ms median",
        "p99",
        "mean",
    ]);
    let rounded = |name: &str, size: String, score: &Score, scored: String, cpu: Spread| {
        vec![
            name.to_owned(),
            size,
            scored,
            cell(score.auc, 3),
            cell(score.precision, 3),
            cell(score.lost, 3),
            score.absent.to_string(),
            cell(score.absent_share().unwrap_or(f64::NAN), 3),
            cell(cpu.median, 3),
            cell(cpu.p99, 3),
            cell(cpu.mean, 3),
        ]
    };
    for clip in all {
        let spread = Spread::of(&clip.cpu_ms);
        table.row(rounded(
            &clip.name,
            clip.size.to_string(),
            &clip.score,
            clip.score.scored.to_string(),
            spread,
        ));
    }
    let spreads: Vec<Spread> =
        all.iter().filter(|clip| timed(clip)).map(|clip| Spread::of(&clip.cpu_ms)).collect();
    let of = |part: fn(&Spread) -> f64| mean(&spreads.iter().map(part).collect::<Vec<_>>());
    let means = Score {
        auc: mean_of(all, |score| score.auc),
        precision: mean_of(all, |score| score.precision),
        lost: mean_of(all, |score| score.lost),
        scored: 0,
        absent: all.iter().map(|clip| clip.score.absent).sum(),
        absent_reported: all.iter().map(|clip| clip.score.absent_reported).sum(),
    };
    let cpu = Spread { median: of(|cpu| cpu.median), p99: of(|cpu| cpu.p99), mean: of(|cpu| cpu.mean) };
    let scored: usize = all.iter().map(|clip| clip.score.scored).sum();
    table.row(rounded("mean over clips", String::new(), &means, scored.to_string(), cpu));
    table.say(&format!("{} on the clips (CPU milliseconds of each tracked frame)", under_test::NAME));
    for clip in all {
        if let Some(refused) = &clip.refused {
            say(&format!("{}: {refused}", clip.name));
        }
    }
}

fn say_beside_csrt(all: &[Measured]) {
    let mut table = Table::new(&[
        "clip",
        "AUC",
        "CSRT",
        "ratio",
        "P20",
        "CSRT",
        "lost",
        "CSRT",
        "ms mean",
        "CSRT",
        "times cheaper",
        "lean CamShift ms",
    ]);
    for clip in all {
        let Some(csrt) = &clip.csrt else { continue };
        let (ours, theirs) = (mean(&clip.cpu_ms), mean(&csrt.cpu_ms));
        table.row(vec![
            clip.name.clone(),
            cell(clip.score.auc, 3),
            cell(csrt.score.auc, 3),
            cell(clip.score.auc / csrt.score.auc, 2),
            cell(clip.score.precision, 3),
            cell(csrt.score.precision, 3),
            cell(clip.score.lost, 3),
            cell(csrt.score.lost, 3),
            cell(ours, 3),
            cell(theirs, 2),
            cell(theirs / ours, 1),
            cell(mean(&csrt.lean_camshift_cpu_ms), 3),
        ]);
    }
    let of = |part: &dyn Fn(&opencv::Result) -> f64| {
        mean(&all.iter().filter_map(|clip| clip.csrt.as_ref().map(part)).collect::<Vec<_>>())
    };
    let auc = mean_of(all, |score| score.auc);
    let csrt_auc = of(&|csrt| csrt.score.auc);
    let cost = Cost::of(all, |_| true);
    table.row(vec![
        "mean over clips".to_owned(),
        cell(auc, 3),
        cell(csrt_auc, 3),
        cell(auc / csrt_auc, 2),
        cell(mean_of(all, |score| score.precision), 3),
        cell(of(&|csrt| csrt.score.precision), 3),
        cell(mean_of(all, |score| score.lost), 3),
        cell(of(&|csrt| csrt.score.lost), 3),
        cell(cost.ours, 3),
        cell(cost.csrt, 2),
        cell(cost.csrt / cost.ours, 1),
        cell(cost.lean_camshift, 3),
    ]);
    table.say("Beside OpenCV's CSRT (one thread, the same clips and selections, in turn)");
}

fn say_upscaled(all: &[Measured]) {
    let mut table = Table::new(&["clip at 1920x1080", "AUC", "ms median", "p99", "mean"]);
    for clip in all {
        let Some((score, cpu_ms)) = &clip.upscaled else { continue };
        let cpu = Spread::of(cpu_ms);
        table.row(vec![
            clip.name.clone(),
            cell(score.auc, 3),
            cell(cpu.median, 3),
            cell(cpu.p99, 3),
            cell(cpu.mean, 3),
        ]);
    }
    table.say("Clips of 1280x720 enlarged to 1920x1080");
}

/// Whether it has a cost: nothing is tracked where the selection was refused.
fn timed(clip: &Measured) -> bool {
    !clip.cpu_ms.is_empty()
}

/// Mean CPU milliseconds a frame over the clips of each, and the mean over those that have a cost.
struct Cost {
    ours: f64,
    csrt: f64,
    lean_camshift: f64,
}

impl Cost {
    fn of(all: &[Measured], which: impl Fn(&Measured) -> bool) -> Self {
        let of = |part: &dyn Fn(&Measured) -> Option<f64>| {
            mean(&all.iter().filter(|clip| timed(clip) && which(clip)).filter_map(part).collect::<Vec<_>>())
        };
        Self {
            ours: of(&|clip| Some(mean(&clip.cpu_ms))),
            csrt: of(&|clip| clip.csrt.as_ref().map(|csrt| mean(&csrt.cpu_ms))),
            lean_camshift: of(&|clip| clip.csrt.as_ref().map(|csrt| mean(&csrt.lean_camshift_cpu_ms))),
        }
    }
}

fn judge(options: &Options, whole: bool, all: &[Measured], requirements: &mut Requirements) {
    if whole {
        requirements.at_least("mean AUC", mean_of(all, |score| score.auc), AUC_WANTED);
        requirements.at_least(
            "mean precision at 20 px",
            mean_of(all, |score| score.precision),
            PRECISION_WANTED,
        );
        requirements.at_most("mean share lost", mean_of(all, |score| score.lost), LOST_WANTED);
    }
    for clip in all {
        if let Some(csrt) = &clip.csrt {
            let name = format!("{}: AUC as a share of CSRT's", clip.name);
            requirements.at_least(&name, clip.score.auc / csrt.score.auc, SHARE_OF_CSRT_WANTED);
        }
    }
    let hd: Vec<f64> =
        all.iter().filter(|clip| clip.size == HD).flat_map(|clip| clip.cpu_ms.clone()).collect();
    if options.csrt {
        let cost = Cost::of(all, |_| true);
        requirements.at_least(
            "times cheaper than CSRT, all clips",
            cost.csrt / cost.ours,
            TIMES_CHEAPER_WANTED,
        );
        if !hd.is_empty() {
            let cost = Cost::of(all, |clip| clip.size == HD);
            let times = cost.csrt / cost.ours;
            requirements.at_least("times cheaper than CSRT, 1280x720", times, TIMES_CHEAPER_WANTED);
            let wanted = format!("below the lean CamShift's {:.3} ms", cost.lean_camshift);
            let cheaper = cost.ours < cost.lean_camshift;
            requirements.add("CPU ms, mean at 1280x720", cost.ours, &wanted, cheaper);
        }
    }
    if !hd.is_empty() {
        let spread = Spread::of(&hd);
        requirements.at_most("CPU ms, median at 1280x720", spread.median, MEDIAN_MS_WANTED);
        requirements.at_most("CPU ms, p99 at 1280x720", spread.p99, P99_MS_WANTED);
    }
    let upscaled: Vec<f64> =
        all.iter().filter_map(|clip| clip.upscaled.as_ref()).flat_map(|(_, cpu_ms)| cpu_ms.clone()).collect();
    if !upscaled.is_empty() {
        let median = Spread::of(&upscaled).median;
        requirements.at_most("CPU ms, median at 1920x1080", median, UPSCALED_MEDIAN_MS_WANTED);
    }
}

fn mean_of(all: &[Measured], part: impl Fn(&Score) -> f64) -> f64 {
    mean(&all.iter().map(|clip| part(&clip.score)).collect::<Vec<_>>())
}

fn to_json(clip: Measured) -> Value {
    let cpu = |times: &[f64]| {
        let spread = Spread::of(times);
        json!({ "median": spread.median, "p99": spread.p99, "mean": spread.mean })
    };
    let score = |score: &Score| {
        json!({
            "auc": score.auc, "precision": score.precision, "lost": score.lost, "scored": score.scored,
            "absent": score.absent, "absent_reported": score.absent_reported,
        })
    };
    json!({
        "clip": clip.name,
        "width": clip.size.width,
        "height": clip.size.height,
        "score": score(&clip.score),
        "cpu_ms": cpu(&clip.cpu_ms),
        "refused": clip.refused.map(|refused| refused.to_string()),
        "csrt": clip.csrt.map(|csrt| json!({
            "score": score(&csrt.score),
            "cpu_ms": cpu(&csrt.cpu_ms),
            "lean_camshift_cpu_ms": cpu(&csrt.lean_camshift_cpu_ms),
            "boxes": csrt.boxes.iter().map(|bounds| bounds.map(corners)).collect::<Vec<_>>(),
        })),
        "jittered": clip.jittered.map(|scores| scores.iter().map(score).collect::<Vec<_>>()),
        "upscaled": clip.upscaled.map(|(of, times)| json!({ "score": score(&of), "cpu_ms": cpu(&times) })),
        "frames": clip.frames,
    })
}

fn frames_json(clip: &Clip, followed: &Followed) -> Value {
    let mut frames = Vec::new();
    for (index, (track, label)) in followed.tracks.iter().zip(clip.tracked_labels()).enumerate() {
        let bounds = track.localisation().map(|seen| seen.bounds);
        let truth = match label {
            Some(Label::There(truth)) => Some(*truth),
            _ => None,
        };
        frames.push(json!({
            "frame": clip.start + 1 + index,
            "state": state_of(track),
            "confidence": confidence_of(track),
            "box": bounds.map(corners),
            "truth": truth.map(corners),
            "absent": *label == Some(Label::Absent),
            "iou": truth.map(|truth| overlap(truth, bounds, clip.size())),
            "cpu_ms": followed.cpu.get(index).map(|time| time.as_secs_f64() * 1e3),
        }));
    }
    Value::Array(frames)
}
