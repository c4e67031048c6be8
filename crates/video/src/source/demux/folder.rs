//! Reads a folder of PNG, JPEG, WebP and TIFF files as a video, in natural order (`2.png` before `10.png`),
//! at a constant rate (30 per second unless the address has `?fps=`).
//!
//! Hidden files and files of other kinds are skipped. The content decides the kind. Pictures may differ in
//! size.

use std::cmp::Ordering;
use std::fs;
use std::path::{Path, PathBuf};

use super::kind::{FileKind, HEAD_BYTES};
use super::picture_file::PictureFile;
use super::stamp::capture_at_rate;
use crate::error::{VideoError, cannot_read};
use barrelman_vocab::unit::EncodedUnit;

/// Pictures per second where the address does not state them.
pub const DEFAULT_FPS: f64 = 30.0;

/// Maximum size of a picture file, bytes: bounds the memory for it.
const MAX_FILE_BYTES: u64 = 256 << 20;

/// Reads the pictures of a folder one by one.
pub struct FolderReader {
    files: Vec<PathBuf>,
    next: usize,
    fps: f64,
}

impl FolderReader {
    /// Lists the pictures of a folder.
    ///
    /// # Errors
    /// A folder that cannot be read or has no picture.
    pub fn open(folder: &Path, fps: Option<f64>) -> Result<Self, VideoError> {
        let mut files = Vec::new();
        for entry in fs::read_dir(folder).map_err(|error| cannot_read(folder, error))? {
            let path = entry.map_err(|error| cannot_read(folder, error))?.path();
            let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
            if !hidden && path.is_file() && FileKind::detect(&head_of(&path)?).is_picture() {
                files.push(path);
            }
        }
        if files.is_empty() {
            return Err(VideoError::Unsupported {
                path: folder.to_owned(),
                what: "a folder without PNG, JPEG, WebP or TIFF pictures".to_owned(),
                remedy: "Give a folder with the pictures themselves in it, or a video file".to_owned(),
            });
        }
        files.sort_by(|a, b| natural_order(&a.to_string_lossy(), &b.to_string_lossy()));
        Ok(Self { files, next: 0, fps: fps.unwrap_or(DEFAULT_FPS) })
    }

    /// A video of a single picture.
    pub fn from_picture(path: &Path, fps: Option<f64>) -> Self {
        Self { files: vec![path.to_owned()], next: 0, fps: fps.unwrap_or(DEFAULT_FPS) }
    }

    /// Number of pictures.
    pub fn unit_count(&self) -> u64 {
        self.files.len() as u64
    }

    /// The next picture.
    ///
    /// # Errors
    /// A file that cannot be read, or is not a picture any more.
    pub fn next_unit(&mut self) -> Result<Option<EncodedUnit>, VideoError> {
        let Some(path) = self.files.get(self.next) else { return Ok(None) };
        let index = self.next as u64;
        self.next += 1;
        let size = fs::metadata(path).map_err(|error| cannot_read(path, error))?.len();
        let damaged =
            |what: &str| VideoError::Damaged { path: path.clone(), units: index, what: what.to_owned() };
        if size > MAX_FILE_BYTES {
            return Err(damaged("the picture file is larger than 256 MiB"));
        }
        let file = fs::read(path).map_err(|error| cannot_read(path, error))?;
        let read = PictureFile::read(FileKind::detect(&file), file);
        let PictureFile { codec, rotation, payload } = read.map_err(|what| damaged(&what))?;
        Ok(Some(EncodedUnit {
            epoch: 0,
            index,
            capture: capture_at_rate(index, self.fps),
            key: true,
            shown: true,
            rotation,
            codec,
            payload,
        }))
    }
}

fn head_of(path: &Path) -> Result<Vec<u8>, VideoError> {
    use std::io::Read;
    let mut head = Vec::new();
    fs::File::open(path)
        .and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head))
        .map_err(|error| cannot_read(path, error))?;
    Ok(head)
}

/// Natural order: runs of digits are compared by value, other text by character.
fn natural_order(a: &str, b: &str) -> Ordering {
    let (mut rest_a, mut rest_b) = (a, b);
    loop {
        let (digits_a, digits_b) = (leading_digits(rest_a), leading_digits(rest_b));
        let order = if !digits_a.is_empty() && !digits_b.is_empty() {
            let (value_a, value_b) = (digits_a.trim_start_matches('0'), digits_b.trim_start_matches('0'));
            rest_a = &rest_a[digits_a.len()..];
            rest_b = &rest_b[digits_b.len()..];
            value_a.len().cmp(&value_b.len()).then_with(|| value_a.cmp(value_b))
        } else {
            match (rest_a.chars().next(), rest_b.chars().next()) {
                // Equal except for leading zeros: any fixed order is right.
                (None, None) => return a.cmp(b),
                (Some(first_a), Some(first_b)) => {
                    rest_a = &rest_a[first_a.len_utf8()..];
                    rest_b = &rest_b[first_b.len_utf8()..];
                    first_a.cmp(&first_b)
                }
                (first_a, first_b) => first_a.cmp(&first_b),
            }
        };
        if order != Ordering::Equal {
            return order;
        }
    }
}

fn leading_digits(text: &str) -> &str {
    &text[..text.bytes().take_while(u8::is_ascii_digit).count()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_names_count_by_value() {
        let mut names = vec!["f10.png", "f2.png", "f1.png", "f02b.png", "g1.png", "f2.jpg", "f", "f010.png"];
        names.sort_by(|a, b| natural_order(a, b));
        assert_eq!(names, ["f", "f1.png", "f2.jpg", "f2.png", "f02b.png", "f010.png", "f10.png", "g1.png"]);
    }
}
