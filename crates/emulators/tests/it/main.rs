//! Integration tests: emulated vehicles at ports and servers, against the links of the program.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

use std::path::{Path, PathBuf};

mod emulated_port;
mod gimbal;
mod onvif;
mod sigma;

/// An empty folder for one test. The name must differ from those of all other tests.
fn empty_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}
