//! Random sessions without a fuzzer: `random [how many]`. The seeds of those that fail are named.

use std::panic::catch_unwind;

fn main() {
    let count = std::env::args().nth(1).and_then(|count| count.parse().ok()).unwrap_or(20_000_u64);
    let failed =
        (0..count).filter(|&seed| catch_unwind(|| barrelman_fuzz::tracker::session(&bytes(seed))).is_err());
    let failed = failed.inspect(|seed| println!("seed {seed} failed")).count();
    println!("{failed} of {count} sessions failed");
    assert_eq!(failed, 0);
}

/// Up to 800 bytes by xorshift.
fn bytes(seed: u64) -> Vec<u8> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    let mut next = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 40) as u8
    };
    let length = 30 + 3 * usize::from(next());
    (0..length).map(|_| next()).collect()
}
