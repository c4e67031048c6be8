//! Compiles the recording's schema: Rust types, and the descriptors that every recording carries.

// A build script reads what cargo tells it and writes what the crate includes.
#![allow(clippy::disallowed_methods)]

use std::io::{Error, Result};
use std::path::PathBuf;

fn main() -> Result<()> {
    println!("cargo::rerun-if-changed=proto");
    let descriptors = protox::compile(["barrelman.proto"], ["proto"]).map_err(Error::other)?;
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or_else(|| Error::other("cargo sets OUT_DIR"))?);
    // The descriptors go into every recording: a reader needs no copy of the schema.
    std::fs::write(out.join("barrelman.binpb"), prost::Message::encode_to_vec(&descriptors))?;
    prost_build::Config::new().compile_fds(descriptors)
}
