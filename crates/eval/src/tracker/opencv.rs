//! OpenCV's trackers on the same clips, through `scripts/acceptance/csrt.py`.
//!
//! The script takes one job a line and answers each with one line, so that both trackers run in turn, clip by
//! clip, and a machine that is busy for a while slows both.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use anyhow::{Context, bail, ensure};
use barrelman_vocab::PixelBox;
use serde::Deserialize;
use serde_json::json;

use super::clips::{Clip, ClipFolder};
use super::scoring::{Score, score};
use crate::root;

/// A running script.
pub(crate) struct OpenCv {
    child: Child,
    jobs: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

/// What CSRT made of one clip.
pub(crate) struct Result {
    pub(crate) score: Score,
    /// One for each frame after the selection's.
    pub(crate) boxes: Vec<Option<PixelBox>>,
    /// CPU time of each.
    pub(crate) cpu_ms: Vec<f64>,
    /// CPU time that a lean CamShift takes of each, of all its stages.
    pub(crate) lean_camshift_cpu_ms: Vec<f64>,
}

#[derive(Deserialize)]
struct Answer {
    boxes: Vec<Option<[f64; 4]>>,
    cpu_ms: Vec<f64>,
    lean_camshift_cpu_ms: Vec<f64>,
}

impl OpenCv {
    /// Starts it.
    ///
    /// # Errors
    /// If there is no such Python.
    pub(crate) fn start(python: &Path) -> anyhow::Result<Self> {
        let mut child = Command::new(python)
            .arg(root()?.join("scripts/acceptance/csrt.py"))
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

    /// Lets it follow what our tracker followed.
    ///
    /// # Errors
    /// If the script fails, or has read other frames than we did.
    pub(crate) fn follow(&mut self, folder: &ClipFolder, clip: &Clip) -> anyhow::Result<Result> {
        let selection = clip.selection;
        let job = json!({
            "video": folder.video(),
            "start": clip.start,
            "selection": [selection.u, selection.v, selection.w, selection.h],
        });
        let jobs = self.jobs.as_mut().context("no jobs after the end")?;
        writeln!(jobs, "{job}").context("csrt.py takes no more jobs")?;
        let mut line = String::new();
        if self.answers.read_line(&mut line)? == 0 {
            bail!("csrt.py ended at {}: {}", clip.name, self.child.wait()?);
        }
        let answer: Answer = serde_json::from_str(&line).with_context(|| line.clone())?;
        let (ours, theirs) = (clip.tracked().len(), answer.boxes.len());
        ensure!(ours == theirs, "{}: {ours} frames here, {theirs} in OpenCV", clip.name);
        let boxes: Vec<Option<PixelBox>> = answer
            .boxes
            .into_iter()
            .map(|bounds| bounds.map(|[u, v, w, h]| PixelBox { u, v, w, h }))
            .collect();
        Ok(Result {
            score: score(clip.tracked_labels(), &boxes, clip.size()),
            boxes,
            cpu_ms: answer.cpu_ms,
            lean_camshift_cpu_ms: answer.lean_camshift_cpu_ms,
        })
    }

    /// Ends it.
    ///
    /// # Errors
    /// If it did not end well.
    pub(crate) fn end(mut self) -> anyhow::Result<()> {
        // It ends where there are no more jobs.
        drop(self.jobs.take());
        let status = self.child.wait()?;
        ensure!(status.success(), "csrt.py: {status}");
        Ok(())
    }
}
