//! What is required of the tracker on the clips.

use super::beside_opencv::MedianCpuMs;
use super::measurement::{ClipMeasurement, HD, mean_score, members};
use crate::statistics::TimingSummary;
use crate::tracker::clip_sets::{ALL, ClipSet, TUNED_ON, UNSEEN};
use crate::tracker::options::Options;
use crate::tracker::requirements::Requirements;
use crate::tracker::scoring::Score;

/// What is required of the means over the clips of a set.
struct Quality {
    set: &'static str,
    min_auc: f64,
    min_precision: f64,
    max_lost: f64,
}

const QUALITY: [Quality; 3] = [
    Quality { set: TUNED_ON, min_auc: 0.72, min_precision: 0.95, max_lost: 0.02 },
    Quality { set: UNSEEN, min_auc: 0.65, min_precision: 0.83, max_lost: 0.08 },
    Quality { set: ALL, min_auc: 0.70, min_precision: 0.88, max_lost: 0.06 },
];

/// On each clip of [`TUNED_ON`] the AUC must be at least this share of CSRT's.
const MIN_SHARE_OF_CSRT_AUC: f64 = 0.8;
const MIN_TIMES_CHEAPER_THAN_CSRT: f64 = 20.0;
const MIN_TIMES_CHEAPER_THAN_NANOTRACK: f64 = 4.0;
/// CPU times of a frame of 1280x720, and of one enlarged to 1920x1080.
const MAX_MEDIAN_MS: f64 = 1.0;
const MAX_P99_MS: f64 = 3.0;
const MAX_UPSCALED_MEDIAN_MS: f64 = 1.5;

/// Judges the clips. The means over a folder are judged only where all its clips were measured.
pub(super) fn judge(
    options: &Options,
    clips: &[ClipMeasurement],
    sets: &[ClipSet],
    requirements: &mut Requirements,
) {
    if options.is_complete() {
        judge_means(clips, sets, requirements);
    }
    let hd: Vec<&ClipMeasurement> = clips.iter().filter(|clip| clip.size == HD).collect();
    if options.opencv {
        judge_beside_opencv(clips, &hd, requirements);
    }
    let hd_cpu_ms: Vec<f64> = hd.iter().flat_map(|clip| clip.cpu_ms.clone()).collect();
    if !hd_cpu_ms.is_empty() {
        let cpu = TimingSummary::from_times_ms(&hd_cpu_ms);
        requirements.at_most("CPU ms, median at 1280x720", cpu.median, MAX_MEDIAN_MS);
        requirements.at_most("CPU ms, p99 at 1280x720", cpu.p99, MAX_P99_MS);
    }
    let upscaled_cpu_ms: Vec<f64> = clips
        .iter()
        .filter_map(|clip| clip.upscaled.as_ref())
        .flat_map(|(_, cpu_ms)| cpu_ms.clone())
        .collect();
    if !upscaled_cpu_ms.is_empty() {
        let median = TimingSummary::from_times_ms(&upscaled_cpu_ms).median;
        requirements.at_most("CPU ms, median at 1920x1080", median, MAX_UPSCALED_MEDIAN_MS);
    }
}

fn judge_means(clips: &[ClipMeasurement], sets: &[ClipSet], requirements: &mut Requirements) {
    let find = |name: &str| sets.iter().find(|set| set.name == name);
    for quality in &QUALITY {
        let Some(set) = find(quality.set) else { continue };
        // The requirement for all clips is one for the clips of both folders.
        if quality.set == ALL && (find(TUNED_ON).is_none() || find(UNSEEN).is_none()) {
            continue;
        }
        let members = members(set, clips);
        let name = |figure: &str| format!("{} ({}): {figure}", set.name, set.len());
        let mean = |value: fn(&Score) -> f64| mean_score(&members, value).over_clips;
        requirements.at_least(&name("mean AUC"), mean(|score| score.auc), quality.min_auc);
        let precision = mean(|score| score.precision);
        requirements.at_least(&name("mean precision at 20 px"), precision, quality.min_precision);
        requirements.at_most(&name("mean share lost"), mean(|score| score.lost), quality.max_lost);
    }
}

fn judge_beside_opencv(clips: &[ClipMeasurement], hd: &[&ClipMeasurement], requirements: &mut Requirements) {
    for clip in clips.iter().filter(|clip| clip.collection == TUNED_ON) {
        if let Some(opencv) = &clip.opencv {
            let name = format!("{}: AUC as a share of CSRT's", clip.name);
            let share = clip.score.auc / opencv.csrt.score.auc;
            requirements.at_least(&name, share, MIN_SHARE_OF_CSRT_AUC);
        }
    }
    let cpu = MedianCpuMs::over_frames(&clips.iter().collect::<Vec<_>>());
    let times = cpu.times_cheaper_than_csrt();
    requirements.at_least("times cheaper than CSRT, all clips", times, MIN_TIMES_CHEAPER_THAN_CSRT);
    let times = cpu.times_cheaper_than_nanotrack();
    requirements.at_least("times cheaper than NanoTrack, all clips", times, MIN_TIMES_CHEAPER_THAN_NANOTRACK);
    if !hd.is_empty() {
        let cpu = MedianCpuMs::over_frames(hd);
        let times = cpu.times_cheaper_than_csrt();
        requirements.at_least("times cheaper than CSRT, 1280x720", times, MIN_TIMES_CHEAPER_THAN_CSRT);
        let requirement = format!("below the lean CamShift's {:.3} ms", cpu.lean_camshift);
        let is_cheaper = cpu.tracker < cpu.lean_camshift;
        requirements.add(
            "CPU ms, median at 1280x720, beside CamShift",
            cpu.tracker,
            &requirement,
            is_cheaper,
        );
    }
}
