//! Which program this is.

use std::sync::LazyLock;

use xxhash_rust::xxh3::xxh3_64;

/// The version of the program and the hash of its file, as `0.1.0+5c1f0a9be2d47f60`: XXH3-64 of the executable in
/// hexadecimal digits. Two programs with the same identity have the same code. Where the executable cannot be read
/// (for example because it was deleted while the program runs) the hash is `unknown`.
///
/// Recordings, drives and campaigns state this identity.
pub fn identity() -> &'static str {
    static IDENTITY: LazyLock<String> = LazyLock::new(|| {
        let executable = std::env::current_exe().and_then(std::fs::read);
        let hash =
            executable.map_or_else(|_| "unknown".to_owned(), |bytes| format!("{:016x}", xxh3_64(&bytes)));
        format!("{}+{hash}", env!("CARGO_PKG_VERSION"))
    });
    &IDENTITY
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
