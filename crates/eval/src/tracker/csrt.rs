//! OpenCV's trackers on the same clips, through `scripts/acceptance/csrt.py`.
//!
//! The script reads one job per line and answers each with one line, so that both trackers run alternately, clip by
//! clip: a machine that is busy for a while slows both.

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

/// The running script.
pub(crate) struct CsrtProcess {
    child: Child,
    jobs: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// The output of CSRT for one clip.
pub(crate) struct CsrtRun {
    pub(crate) score: Score,
    /// One for each tracked frame.
    pub(crate) boxes: Vec<Option<PixelBox>>,
    /// CPU time of each tracked frame, milliseconds.
    pub(crate) cpu_ms: Vec<f64>,
    /// CPU time of all stages of a lean CamShift for each tracked frame, milliseconds.
    pub(crate) lean_camshift_cpu_ms: Vec<f64>,
}

#[derive(Deserialize)]
struct Answer {
    boxes: Vec<Option<[f64; 4]>>,
    cpu_ms: Vec<f64>,
    lean_camshift_cpu_ms: Vec<f64>,
}

impl CsrtProcess {
    /// Starts the script.
    ///
    /// # Errors
    /// If Python cannot be started.
    pub(crate) fn start(python: &Path) -> Result<Self> {
        let mut child = Command::new(python)
            .arg(workspace_root()?.join("scripts/acceptance/csrt.py"))
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

    /// Runs CSRT over a clip, with the clip's selection.
    ///
    /// # Errors
    /// If the script fails, or has decoded a different number of frames.
    pub(crate) fn run(&mut self, folder: &ClipFolder, clip: &Clip) -> Result<CsrtRun> {
        let selection = clip.selection;
        let job = json!({
            "video": folder.video_path(),
            "start": clip.start,
            "selection": [selection.u, selection.v, selection.w, selection.h],
        });
        let jobs = self.jobs.as_mut().context("csrt.py was ended")?;
        writeln!(jobs, "{job}").context("csrt.py does not accept the job")?;
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            bail!("csrt.py ended at {}: {}", clip.name, self.child.wait()?);
        }
        let answer: Answer = serde_json::from_str(&line).with_context(|| line.clone())?;
        let (ours, theirs) = (clip.tracked_frames().len(), answer.boxes.len());
        ensure!(ours == theirs, "{}: {ours} frames here, {theirs} in OpenCV", clip.name);
        let boxes: Vec<Option<PixelBox>> = answer
            .boxes
            .into_iter()
            .map(|bounds| bounds.map(|[u, v, w, h]| PixelBox { u, v, w, h }))
            .collect();
        Ok(CsrtRun {
            score: score_boxes(clip.tracked_labels(), &boxes, clip.size()),
            boxes,
            cpu_ms: answer.cpu_ms,
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
        ensure!(status.success(), "csrt.py: {status}");
        Ok(())
    }
}
