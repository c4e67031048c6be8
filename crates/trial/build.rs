//! Compiles the recording's schema: Rust types, and the descriptors that every recording carries.

use std::io::{Error, Result};
use std::path::PathBuf;

fn main() -> Result<()> {
    println!("cargo::rerun-if-changed=proto");
    let descriptors = protox::compile(["barrelman.proto"], ["proto"]).map_err(Error::other)?;
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or_else(|| Error::other("cargo sets OUT_DIR"))?);
    // The descriptors also go into every recording: a reader needs no copy of the schema.
    let mut config = prost_build::Config::new();
    config.file_descriptor_set_path(out.join("barrelman.binpb"));
    std::fs::write(out.join("barrelman.binpb"), prost::Message::encode_to_vec(&descriptors))?;
    config.skip_protoc_run().compile_fds(descriptors)
}
