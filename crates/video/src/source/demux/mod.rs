//! Reads encoded units from video files: detects the kind of a file (by its content, never by its name), with
//! a reader for each kind.
//!
//! | file | read by |
//! |---|---|
//! | MP4, MOV with H.264 | [`mp4`] |
//! | Y4M | [`y4m`] |
//! | PNG, JPEG, WebP, TIFF, a folder of them | [`folder`] |
//!
//! | everything else | [`media`], by GStreamer |
//!
//! Where GStreamer is not installed, the error names the commands that install it and that convert the file.
//! Memory is bounded: only the index and one picture of a file are held.

mod reader;

pub mod folder;
pub mod mp4;
pub mod y4m;

pub mod media;

mod picture_file;

mod mp4_boxes;
mod mp4_index;
mod mp4_samples;

pub mod kind;
mod stamp;

pub use reader::FileReader;
