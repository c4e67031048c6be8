//! MP4 files written. The files are read by [`crate::demux`].

pub mod writer;

mod muxer;
