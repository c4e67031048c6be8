//! Random bytes of the operating system, for secrets. Nothing that is simulated or replayed uses them.

use std::io;

use rustix::rand::{GetRandomFlags, getrandom};

/// Fills `bytes` with random bytes.
///
/// # Errors
/// If the system gives no random bytes.
pub fn random_bytes(bytes: &mut [u8]) -> io::Result<()> {
    let mut filled = 0;
    while filled < bytes.len() {
        filled += getrandom(&mut bytes[filled..], GetRandomFlags::empty())?;
    }
    Ok(())
}
