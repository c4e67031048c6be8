//! OpenCV's trackers on the same clips, through `scripts/acceptance/opencv_trackers.py`.
//!
//! The script reads one job per line and answers each with one line, so that all trackers run alternately,
//! clip by clip: a machine that is busy for a while slows all of them.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, Result, bail, ensure};
use barrelman_vocab::PixelBox;
use serde::Deserialize;
use serde_json::json;

use super::clips::{Clip, ClipFolder};
use super::scoring::{Score, score_boxes};
use crate::workspace::workspace_root;

/// The files of NanoTrack's models.
const MODELS: [&str; 2] = ["nanotrack_backbone_sim.onnx", "nanotrack_head_sim.onnx"];

/// The running script.
pub(crate) struct OpencvProcess {
    child: Child,
    jobs: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// The output of OpenCV's trackers for one clip.
pub(crate) struct OpencvRuns {
    pub(crate) csrt: OpencvRun,
    pub(crate) nanotrack: OpencvRun,
    /// CPU time of all stages of a lean CamShift for each tracked frame, milliseconds.
    pub(crate) lean_camshift_cpu_ms: Vec<f64>,
}

/// The output of one of OpenCV's trackers for one clip.
pub(crate) struct OpencvRun {
    pub(crate) score: Score,
    /// One for each tracked frame.
    pub(crate) boxes: Vec<Option<PixelBox>>,
    /// CPU time of each tracked frame, milliseconds.
    pub(crate) cpu_ms: Vec<f64>,
}

#[derive(Deserialize)]
struct Answer {
    csrt: TrackerAnswer,
    nanotrack: TrackerAnswer,
    lean_camshift_cpu_ms: Vec<f64>,
}

#[derive(Deserialize)]
struct TrackerAnswer {
    boxes: Vec<Option<[f64; 4]>>,
    cpu_ms: Vec<f64>,
}

impl TrackerAnswer {
    fn scored(self, clip: &Clip) -> Result<OpencvRun> {
        let (ours, theirs) = (clip.tracked_frames().len(), self.boxes.len());
        ensure!(ours == theirs, "{}: {ours} frames here, {theirs} in OpenCV", clip.name);
        let boxes: Vec<Option<PixelBox>> =
            self.boxes.into_iter().map(|bounds| bounds.map(|[u, v, w, h]| PixelBox { u, v, w, h })).collect();
        let score = score_boxes(clip.tracked_labels(), &boxes, clip.size());
        Ok(OpencvRun { score, boxes, cpu_ms: self.cpu_ms })
    }
}

impl OpencvProcess {
    /// Starts the script, with the folder of NanoTrack's models.
    ///
    /// # Errors
    /// If a model is not there, or Python cannot be started.
    pub(crate) fn start(python: &Path, models: &Path) -> Result<Self> {
        check_models(models)?;
        let mut child = Command::new(python)
            .arg(workspace_root()?.join("scripts/acceptance/opencv_trackers.py"))
            .arg(models)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .with_context(|| {
                format!(
                    "{} cannot be started (--python PATH; scripts/setup.sh test makes one)",
                    python.display()
                )
            })?;
        let jobs = child.stdin.take().context("standard input is a pipe")?;
        let answers = BufReader::new(child.stdout.take().context("standard output is a pipe")?);
        Ok(Self { child, jobs: Some(jobs), answers })
    }

    /// Runs OpenCV's trackers over a clip, with the clip's selection.
    ///
    /// # Errors
    /// If the script fails, or has decoded a different number of frames.
    pub(crate) fn run(&mut self, folder: &ClipFolder, clip: &Clip) -> Result<OpencvRuns> {
        let selection = clip.selection;
        let job = json!({
            "video": folder.video_path(),
            "start": clip.start,
            "selection": [selection.u, selection.v, selection.w, selection.h],
        });
        let jobs = self.jobs.as_mut().context("opencv_trackers.py was ended")?;
        writeln!(jobs, "{job}").context("opencv_trackers.py does not accept the job")?;
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            bail!("opencv_trackers.py ended at {}: {}", clip.name, self.child.wait()?);
        }
        let answer: Answer = serde_json::from_str(&line).with_context(|| line.clone())?;
        Ok(OpencvRuns {
            csrt: answer.csrt.scored(clip)?,
            nanotrack: answer.nanotrack.scored(clip)?,
            lean_camshift_cpu_ms: answer.lean_camshift_cpu_ms,
        })
    }

    /// Ends the script.
    ///
    /// # Errors
    /// If the script fails.
    pub(crate) fn end(mut self) -> Result<()> {
        // The script ends at the end of its input.
        drop(self.jobs.take());
        let status = self.child.wait()?;
        ensure!(status.success(), "opencv_trackers.py: {status}");
        Ok(())
    }
}

fn check_models(folder: &Path) -> Result<()> {
    for name in MODELS {
        let is_there = folder.join(name).is_file();
        ensure!(is_there, "{} does not hold NanoTrack's model {name} (--models DIR)", folder.display());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_without_models_is_an_error_that_names_the_option() {
        let error = OpencvProcess::start(Path::new("python"), Path::new("no/such/folder")).err().unwrap();
        let text = error.to_string();
        assert!(text.contains("no/such/folder") && text.contains("--models"), "{text}");
    }
}
