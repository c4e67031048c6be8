//! Labelled clips: a folder each, with `video.mp4` and `gt.csv` (frame, x, y, w, h in pixels; w = h = 0 where the
//! target is absent).

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use barrelman_video::{FileFrames, VideoUrl};
use barrelman_vocab::{PictureSize, PixelBox, VideoFrame};

use super::scoring::Label;

/// A clip on disk.
#[derive(Debug, Clone)]
pub(crate) struct ClipFolder {
    /// The folder's name.
    pub(crate) name: String,
    folder: PathBuf,
}

/// A decoded clip.
pub(crate) struct Clip {
    /// The folder's name.
    pub(crate) name: String,
    /// All its frames.
    pub(crate) frames: Vec<VideoFrame>,
    /// One for each frame; none where nobody labelled it.
    pub(crate) labels: Vec<Option<Label>>,
    /// The frame of the selection: the first in which the target is labelled.
    pub(crate) start: usize,
    /// The selection: its label.
    pub(crate) selection: PixelBox,
}

impl Clip {
    /// Size of its pictures.
    pub(crate) fn size(&self) -> PictureSize {
        self.frames[self.start].picture.size()
    }

    /// The frames after the selection's, which are those that are tracked.
    pub(crate) fn tracked(&self) -> &[VideoFrame] {
        &self.frames[self.start + 1..]
    }

    /// The labels of those.
    pub(crate) fn tracked_labels(&self) -> &[Option<Label>] {
        &self.labels[self.start + 1..]
    }
}

/// The clips in a folder, by name; only those of `names` where there are any.
///
/// # Errors
/// If the folder has none, or one of the names is not in it.
pub(crate) fn list(folder: &Path, names: &[String]) -> Result<Vec<ClipFolder>> {
    let there = || format!("the clips are looked for in {} (--clips DIR)", folder.display());
    let mut clips = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(there)? {
        let folder = entry?.path();
        if folder.join("video.mp4").is_file() && folder.join("gt.csv").is_file() {
            let name = folder.file_name().context("a folder has a name")?.to_string_lossy().into_owned();
            clips.push(ClipFolder { name, folder });
        }
    }
    clips.sort_by(|a, b| a.name.cmp(&b.name));
    for name in names {
        if !clips.iter().any(|clip| clip.name == *name) {
            let known: Vec<&str> = clips.iter().map(|clip| clip.name.as_str()).collect();
            bail!("there is no clip {name}; there are {}", known.join(", "));
        }
    }
    clips.retain(|clip| names.is_empty() || names.contains(&clip.name));
    ensure!(!clips.is_empty(), "{} holds no folder with video.mp4 and gt.csv", folder.display());
    Ok(clips)
}

impl ClipFolder {
    /// Its video.
    pub(crate) fn video(&self) -> PathBuf {
        self.folder.join("video.mp4")
    }

    /// Decodes all of it.
    ///
    /// # Errors
    /// If the video or the labels cannot be read, or no frame has a label.
    pub(crate) fn load(&self) -> Result<Clip> {
        let video = self.video();
        let mut reader = FileFrames::open(&VideoUrl::parse(&video.to_string_lossy())?)?;
        let mut frames = Vec::new();
        while let Some(frame) = reader.next_frame()? {
            frames.push(frame);
        }
        let path = self.folder.join("gt.csv");
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let labels = parse(&text, frames.len()).with_context(|| path.display().to_string())?;
        let first = labels.iter().enumerate().find_map(|(frame, label)| match label {
            Some(Label::There(bounds)) => Some((frame, *bounds)),
            _ => None,
        });
        let (start, selection) =
            first.with_context(|| format!("{}: no frame has a label", path.display()))?;
        Ok(Clip { name: self.name.clone(), frames, labels, start, selection })
    }
}

/// The labels of so many frames. Those of frames beyond the end are left out.
fn parse(text: &str, frames: usize) -> Result<Vec<Option<Label>>> {
    let mut labels = vec![None; frames];
    let mut lines = text.lines();
    ensure!(lines.next().map(str::trim) == Some("frame,x,y,w,h"), "the header is not frame,x,y,w,h");
    for line in lines.filter(|line| !line.trim().is_empty()) {
        let cells: Vec<f64> = line
            .split(',')
            .map(|cell| cell.trim().parse())
            .collect::<Result<_, _>>()
            .with_context(|| line.to_owned())?;
        let [frame, u, v, w, h] = cells[..] else { bail!("{line}: five numbers make a label") };
        ensure!(frame >= 0.0 && frame.fract() == 0.0, "{line}: the frame is a whole number");
        if let Some(label) = labels.get_mut(frame as usize) {
            let bounds = PixelBox { u, v, w, h };
            *label = Some(if bounds.is_empty() { Label::Absent } else { Label::There(bounds) });
        }
    }
    Ok(labels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_there_or_absent_or_not_given() {
        let labels = parse("frame,x,y,w,h\n0,1,2,3.5,4\n2,0,0,0,0\n9,1,1,1,1\n", 3).unwrap();
        let bounds = PixelBox { u: 1.0, v: 2.0, w: 3.5, h: 4.0 };
        assert_eq!(labels, [Some(Label::There(bounds)), None, Some(Label::Absent)]);
    }

    #[test]
    fn what_is_no_label_is_refused() {
        for text in [
            "0,1,2,3,4",
            "frame,x,y,w,h\n0,1,2,3",
            "frame,x,y,w,h\n0,1,2,3,four",
            "frame,x,y,w,h\n0.5,1,2,3,4",
        ] {
            assert!(parse(text, 3).is_err(), "{text}");
        }
    }
}
