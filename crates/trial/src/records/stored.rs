//! The messages as stored, generated from `proto/barrelman.proto`.
#![allow(missing_docs, unreachable_pub, clippy::all)]

include!(concat!(env!("OUT_DIR"), "/barrelman.rs"));
