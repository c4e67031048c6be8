//! Labelled clips: a folder each with `video.mp4` and `gt.csv` (or the simulator's `truth.csv`). A row of
//! `gt.csv` is frame, x, y, w, h in pixels; w and h are 0 where the target is absent.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use barrelman_video::{VideoFrames, VideoUrl};
use barrelman_vocab::{PictureSize, PixelBox, VideoFrame};

use super::scoring::Label;

/// A clip on disk.
#[derive(Debug, Clone)]
pub(crate) struct ClipFolder {
    /// The folder's name.
    pub(crate) name: String,
    /// The name of the folder of clips that holds it.
    pub(crate) collection: String,
    folder: PathBuf,
}

/// A decoded clip.
pub(crate) struct Clip {
    /// The folder's name.
    pub(crate) name: String,
    /// All frames.
    pub(crate) frames: Vec<VideoFrame>,
    /// One for each frame; `None` where the frame is not labelled.
    pub(crate) labels: Vec<Option<Label>>,
    /// The index of the selection's frame: the first in which the target is labelled as visible.
    pub(crate) start: usize,
    /// The selection: the label of that frame.
    pub(crate) selection: PixelBox,
}

impl Clip {
    /// A clip whose selection is the first label with the target in view.
    ///
    /// # Errors
    /// If the target is in view in no labelled frame.
    pub(crate) fn new(name: String, frames: Vec<VideoFrame>, labels: Vec<Option<Label>>) -> Result<Self> {
        let first = labels.iter().enumerate().find_map(|(frame, label)| match label {
            Some(Label::Visible(bounds)) => Some((frame, *bounds)),
            _ => None,
        });
        let (start, selection) =
            first.with_context(|| format!("{name}: the target is visible in no labelled frame"))?;
        Ok(Self { name, frames, labels, start, selection })
    }

    /// Size of the pictures.
    pub(crate) fn size(&self) -> PictureSize {
        self.frames[self.start].picture.size()
    }

    /// The frames that are tracked: those after the selection's.
    pub(crate) fn tracked_frames(&self) -> &[VideoFrame] {
        &self.frames[self.start + 1..]
    }

    /// The labels of the tracked frames.
    pub(crate) fn tracked_labels(&self) -> &[Option<Label>] {
        &self.labels[self.start + 1..]
    }
}

/// The clips in these folders: folder by folder, in the order of their names; only those in `names` unless
/// `names` is empty.
///
/// # Errors
/// If a folder has no clip, two clips have the same name, or a name is in no folder.
pub(crate) fn list_clips(folders: &[PathBuf], names: &[String]) -> Result<Vec<ClipFolder>> {
    let mut clips = Vec::new();
    for folder in folders {
        clips.extend(clips_in(folder)?);
    }
    choose_clips(clips, names)
}

/// The clips in a folder in the order of their names.
fn clips_in(folder: &Path) -> Result<Vec<ClipFolder>> {
    let context = || format!("cannot read the folder of clips {} (--clips DIR)", folder.display());
    let collection = folder.file_name().map_or(folder.to_string_lossy(), |name| name.to_string_lossy());
    let mut clips = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(context)? {
        let folder = entry?.path();
        let has_labels = folder.join("gt.csv").is_file() || folder.join("truth.csv").is_file();
        if folder.join("video.mp4").is_file() && has_labels {
            let name = folder.file_name().context("a folder has a name")?.to_string_lossy().into_owned();
            clips.push(ClipFolder { name, collection: collection.clone().into_owned(), folder });
        }
    }
    ensure!(!clips.is_empty(), "{} holds no folder with video.mp4 and gt.csv or truth.csv", folder.display());
    clips.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(clips)
}

/// The clips with these names; all where no name is given.
fn choose_clips(mut clips: Vec<ClipFolder>, names: &[String]) -> Result<Vec<ClipFolder>> {
    let mut known = BTreeSet::new();
    for clip in &clips {
        ensure!(known.insert(clip.name.clone()), "two clips are named {}: give each folder once", clip.name);
    }
    for name in names {
        let known: Vec<&str> = known.iter().map(String::as_str).collect();
        ensure!(known.contains(&name.as_str()), "unknown clip {name}; known are {}", known.join(", "));
    }
    clips.retain(|clip| names.is_empty() || names.contains(&clip.name));
    Ok(clips)
}

impl ClipFolder {
    /// A clip that is not on disk.
    #[cfg(test)]
    pub(crate) fn for_test(name: &str, collection: &str) -> Self {
        Self { name: name.to_owned(), collection: collection.to_owned(), folder: PathBuf::new() }
    }

    /// Path of the video.
    pub(crate) fn video_path(&self) -> PathBuf {
        self.folder.join("video.mp4")
    }

    /// Decodes all frames and reads the labels.
    ///
    /// # Errors
    /// If the video or the labels cannot be read, or no frame is labelled.
    pub(crate) fn load(&self) -> Result<Clip> {
        let video = self.video_path();
        let mut reader = VideoFrames::open(&VideoUrl::parse(&video.to_string_lossy())?)?;
        let mut frames = Vec::new();
        while let Some(frame) = reader.next_frame()? {
            frames.push(frame);
        }
        let (labels, truth) = (self.folder.join("gt.csv"), self.folder.join("truth.csv"));
        let path = if labels.is_file() { labels } else { truth };
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        let text = if path.ends_with("truth.csv") { labels_of_truth(&text)? } else { text };
        let labels = parse_labels(&text, frames.len()).with_context(|| path.display().to_string())?;
        Clip::new(self.name.clone(), frames, labels).with_context(|| path.display().to_string())
    }
}

/// The labels in a truth.csv of the simulator. A target of which less than half is visible counts as absent.
fn labels_of_truth(text: &str) -> Result<String> {
    let mut labels = "frame,x,y,w,h\n".to_owned();
    for line in text.lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let [frame, _, u, v, w, h, _, _, visible, ..] = cells[..] else {
            bail!("{line}: not a row of truth")
        };
        let is_visible = visible.parse::<f64>().is_ok_and(|share| share >= 0.5);
        let (w, h) = if is_visible { (w, h) } else { ("0", "0") };
        labels += &format!("{frame},{u},{v},{w},{h}\n");
    }
    Ok(labels)
}

/// Parses the labels of a number of frames. Labels of later frames are ignored.
fn parse_labels(text: &str, frames: usize) -> Result<Vec<Option<Label>>> {
    let mut labels = vec![None; frames];
    let mut lines = text.lines();
    ensure!(lines.next().map(str::trim) == Some("frame,x,y,w,h"), "the header must be frame,x,y,w,h");
    for line in lines.filter(|line| !line.trim().is_empty()) {
        let cells: Vec<f64> = line
            .split(',')
            .map(|cell| cell.trim().parse())
            .collect::<Result<_, _>>()
            .with_context(|| line.to_owned())?;
        let [frame, u, v, w, h] = cells[..] else { bail!("{line}: a label has five numbers") };
        ensure!(frame >= 0.0 && frame.fract() == 0.0, "{line}: the frame must be a whole number");
        if let Some(label) = labels.get_mut(frame as usize) {
            let bounds = PixelBox { u, v, w, h };
            *label = Some(if bounds.is_empty() { Label::Absent } else { Label::Visible(bounds) });
        }
    }
    Ok(labels)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> ClipFolder {
        ClipFolder::for_test(name, "clips")
    }

    #[test]
    fn clips_are_chosen_by_their_names() {
        let names = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|&name| name.to_owned()).collect();
            let chosen = choose_clips(vec![folder("b"), folder("a")], &names);
            chosen.map(|clips| clips.into_iter().map(|clip| clip.name).collect::<Vec<_>>())
        };
        assert_eq!(names(&[]).unwrap(), ["b", "a"]);
        assert_eq!(names(&["a"]).unwrap(), ["a"]);
        assert!(names(&["c"]).is_err());
    }

    #[test]
    fn two_clips_of_one_name_are_refused() {
        assert!(choose_clips(vec![folder("a"), folder("a")], &[]).is_err());
    }

    #[test]
    fn labels_are_visible_or_absent_or_not_given() {
        let labels = parse_labels("frame,x,y,w,h\n0,1,2,3.5,4\n2,0,0,0,0\n9,1,1,1,1\n", 3).unwrap();
        let bounds = PixelBox { u: 1.0, v: 2.0, w: 3.5, h: 4.0 };
        assert_eq!(labels, [Some(Label::Visible(bounds)), None, Some(Label::Absent)]);
    }

    #[test]
    fn what_is_no_label_is_refused() {
        for text in [
            "0,1,2,3,4",
            "frame,x,y,w,h\n0,1,2,3",
            "frame,x,y,w,h\n0,1,2,3,four",
            "frame,x,y,w,h\n0.5,1,2,3,4",
        ] {
            assert!(parse_labels(text, 3).is_err(), "{text}");
        }
    }
}
