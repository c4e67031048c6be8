//! Sources of video: where encoded units come from, live or from a file, and how they reach their receiver.
//!
//! A file is read by [`demux`], a network stream by `rtsp`. Both pass their units through a [`feed::Feed`]: a
//! way with or without deliberate faults, then the decoder, then the receiver's [`sink::VideoSink`].

pub mod sink;
pub mod url;

pub mod live;

pub mod frames;

pub mod feed;

mod faulty_path;

pub mod demux;
mod pipe;

mod receiver;

mod rtsp;
mod rtsp_filter;
mod rtsp_relay;

mod media_engine;

pub mod sender_clock;
pub mod supervision;
mod wall_time;
