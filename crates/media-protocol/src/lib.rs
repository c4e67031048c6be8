//! What `barrelman` and `barrelman-media` say to each other.
//!
//! `barrelman-media` is a program of its own that links GStreamer. One process has one [`Role`]:
//! ```text
//!              first message: Role                     FromSource + encoded unit
//!  barrelman ----------------------> barrelman-media (source) ------------------> barrelman
//!
//!              ToDecoder + encoded unit                FromDecoder + planes
//!  barrelman ----------------------> barrelman-media (decoder) -----------------> barrelman
//!
//!              ToShare + encoded unit                  RTSP
//!  barrelman ----------------------> barrelman-media (share) -------------------> readers
//!            <---------------------- FromShare: what the readers need
//! ```
//! A source turns an address into encoded units. A decoder turns units into pictures, whether the units come
//! from a source, from a recording or from a file: a replay decodes exactly what the live run decoded.
//! Neither knows the other.
//!
//! The processes are joined by a pair of Unix sockets; the far end's is its standard input. A
//! [`channel::Channel`] carries messages in both directions: a short header (`postcard`) and a payload. Both
//! lengths are bounded, since the far end reads what strangers send. Pictures cross the socket as bytes
//! rather than in shared memory: a process that has been taken over cannot change a picture while it is read.
//!
//! What must not be here: GStreamer, threads, clocks, decisions about when to connect.
#![forbid(unsafe_code)]

pub mod channel;

pub mod role;

pub mod source;

pub mod failure;

pub mod decoder;

pub mod share;

pub mod format;
