//! Which program this is.

use std::fs::File;
use std::io::{self, Read as _};
use std::sync::LazyLock;

use xxhash_rust::xxh3::Xxh3;

/// Bytes of the executable that are in memory at a time.
const BLOCK_BYTES: usize = 1 << 16;

/// The version of the program and the hash of its file, as `0.1.0+5c1f0a9be2d47f60`: XXH3-64 of the
/// executable in hexadecimal digits. Two programs with the same identity have the same code. Where the
/// executable cannot be read (for example because it was deleted while the program runs) the hash is
/// `unknown`.
///
/// Recordings, drives and campaigns state this identity.
pub fn identity() -> &'static str {
    static IDENTITY: LazyLock<String> = LazyLock::new(|| {
        let hash = hash_of_executable().map_or_else(|_| "unknown".to_owned(), |hash| format!("{hash:016x}"));
        format!("{}+{hash}", env!("CARGO_PKG_VERSION"))
    });
    &IDENTITY
}

fn hash_of_executable() -> io::Result<u64> {
    let mut executable = File::open(std::env::current_exe()?)?;
    let (mut hash, mut block) = (Xxh3::new(), vec![0; BLOCK_BYTES]);
    loop {
        match executable.read(&mut block)? {
            0 => return Ok(hash.digest()),
            read => hash.update(&block[..read]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_identity_is_the_version_and_the_hash_of_the_executable() {
        let (version, hash) = identity().split_once('+').unwrap();
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        assert!(hash.len() == 16 && hash.bytes().all(|byte| byte.is_ascii_hexdigit()), "{hash}");
    }
}
