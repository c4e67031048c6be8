//! A file in memory, for decoders that read files.

use std::fs::File;
use std::io::Write as _;
use std::os::fd::AsRawFd as _;
use std::path::PathBuf;

use rustix::fs::{MemfdFlags, memfd_create};

/// A file that exists only in memory, and as long as this value.
pub(crate) struct MemoryFile(File);

impl MemoryFile {
    pub(crate) fn new(content: &[u8]) -> Self {
        let file = memfd_create("input", MemfdFlags::CLOEXEC).expect("Linux has files in memory");
        let mut file = File::from(file);
        file.write_all(content).expect("there is room for an input");
        Self(file)
    }

    pub(crate) fn path(&self) -> PathBuf {
        format!("/proc/self/fd/{}", self.0.as_raw_fd()).into()
    }
}
