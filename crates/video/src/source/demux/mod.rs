//! Reads encoded units from video files: detects the kind of a file (by its content, never by its name), with a reader for
//! each kind.
//!
//! | file | read by |
//! |---|---|
//! | MP4, MOV with H.264 | [`mp4`] |
//! | Y4M | [`y4m`] |
//! | PNG, JPEG, a folder of them | [`folder`] |
//!
//! For other kinds, the error names the command that converts the file. Memory is bounded: only the index and one picture
//! of a file are held.

mod reader;

pub mod folder;
pub mod mp4;
pub mod y4m;

mod mp4_boxes;
mod mp4_index;

pub mod kind;
mod stamp;

pub use reader::FileReader;
