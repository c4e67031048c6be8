//! Recordings to encoded units: which kind of file it is (by its content, never by its name), and a reader for
//! each kind.
//!
//! | file | read by |
//! |---|---|
//! | MP4, MOV with H.264 | [`mp4`] |
//! | Y4M | [`y4m`] |
//! | PNG, JPEG, a folder of them | [`folder`] |
//!
//! Anything else is named in the error with the command that converts it. Memory is bounded: of a file, only its
//! index and one picture are held.

mod reader;

pub mod folder;
pub mod mp4;
pub mod y4m;

mod mp4_boxes;
mod mp4_index;

pub mod kind;
mod stamp;

pub use reader::FileReader;
