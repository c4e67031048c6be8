//! What is required of the tracker on the clips.

use super::measurement::{ClipMeasurement, HD, MeanCpuMs, mean_score};
use crate::statistics::TimingSummary;
use crate::tracker::options::Options;
use crate::tracker::requirements::Requirements;

const MIN_AUC: f64 = 0.72;
const MIN_PRECISION: f64 = 0.93;
const MAX_LOST: f64 = 0.04;
/// On each clip the AUC must be at least this share of CSRT's.
const MIN_SHARE_OF_CSRT_AUC: f64 = 0.8;
const MIN_TIMES_CHEAPER: f64 = 20.0;
/// CPU times of a frame of 1280x720, and of one enlarged to 1920x1080.
const MAX_MEDIAN_MS: f64 = 1.0;
const MAX_P99_MS: f64 = 3.0;
const MAX_UPSCALED_MEDIAN_MS: f64 = 1.5;

/// Judges the clips. The means over all clips are judged only where all clips were measured.
pub(super) fn judge(
    options: &Options,
    is_complete: bool,
    clips: &[ClipMeasurement],
    requirements: &mut Requirements,
) {
    if is_complete {
        requirements.at_least("mean AUC", mean_score(clips, |score| score.auc), MIN_AUC);
        requirements.at_least(
            "mean precision at 20 px",
            mean_score(clips, |score| score.precision),
            MIN_PRECISION,
        );
        requirements.at_most("mean share lost", mean_score(clips, |score| score.lost), MAX_LOST);
    }
    for clip in clips {
        if let Some(csrt) = &clip.csrt {
            let name = format!("{}: AUC as a share of CSRT's", clip.name);
            requirements.at_least(&name, clip.score.auc / csrt.score.auc, MIN_SHARE_OF_CSRT_AUC);
        }
    }
    let hd_cpu_ms: Vec<f64> =
        clips.iter().filter(|clip| clip.size == HD).flat_map(|clip| clip.cpu_ms.clone()).collect();
    if options.csrt {
        let cpu = MeanCpuMs::over_clips(clips, |_| true);
        requirements.at_least(
            "times cheaper than CSRT, all clips",
            cpu.csrt / cpu.tracker,
            MIN_TIMES_CHEAPER,
        );
        if !hd_cpu_ms.is_empty() {
            let cpu = MeanCpuMs::over_clips(clips, |clip| clip.size == HD);
            let times = cpu.csrt / cpu.tracker;
            requirements.at_least("times cheaper than CSRT, 1280x720", times, MIN_TIMES_CHEAPER);
            let requirement = format!("below the lean CamShift's {:.3} ms", cpu.lean_camshift);
            let is_cheaper = cpu.tracker < cpu.lean_camshift;
            requirements.add("CPU ms, mean at 1280x720", cpu.tracker, &requirement, is_cheaper);
        }
    }
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
