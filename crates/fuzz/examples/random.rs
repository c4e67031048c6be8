//! Random inputs without a fuzzer: `random [how many] [target] [seconds]`. The seeds of those that fail are
//! named.
//!
//! Half of the inputs are pieces of what the target knows, in any order and damaged: pure noise does not come
//! far in a protocol of lines.
#![allow(clippy::print_stdout, reason = "it prints on a terminal")]

use std::panic::catch_unwind;
use std::time::{Duration, Instant};

use barrelman_fuzz::TARGETS;

/// What the targets know: lines of both ends of the protocol, of logs, of plans of faults, and control bytes.
const PIECES: [&[u8]; 26] = [
    b"!GroundStatus ",
    b"!FlightStatus ",
    b"!Attitude ",
    b"!Gimbal ",
    b"!Position ",
    b"!Pos ",
    b"$ ",
    b"# ",
    b"\r\n",
    b"\r",
    b"\n",
    b"Yaw ",
    b"GimbalPitch ",
    b"Gimbal ",
    b"Pset 117,",
    b"Get_Att 0",
    b"start",
    b"stop",
    b"0.300000",
    b"-1e308",
    b"nan",
    b",1,0,0,0",
    b"stall@5+2",
    b"link: ",
    b"x_val,y_val,pitch,yaw,val,time",
    b"\xf8\x20",
];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let count = arguments.next().and_then(|count| count.parse().ok()).unwrap_or(20_000_u64);
    let wanted = arguments.next();
    let seconds = arguments.next().and_then(|seconds| seconds.parse().ok()).unwrap_or(u64::MAX);
    let mut failed = 0;
    for (name, target) in
        TARGETS.into_iter().filter(|(name, _)| wanted.as_deref().is_none_or(|wanted| wanted == *name))
    {
        let (begun, mut made) = (Instant::now(), 0_u64);
        for seed in 0..count {
            if begun.elapsed() >= Duration::from_secs(seconds) {
                break;
            }
            made += 1;
            if catch_unwind(|| target(&bytes(seed))).is_err() {
                println!("{name}: seed {seed} failed");
                failed += 1;
            }
        }
        println!("{name}: {made} inputs in {:.0} s", begun.elapsed().as_secs_f64());
    }
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
    if seed.is_multiple_of(2) {
        return (0..length).map(|_| next()).collect();
    }
    let mut made = Vec::new();
    while made.len() < length {
        match next() {
            0..32 => made.push(next()),
            piece => made.extend_from_slice(PIECES[usize::from(piece) % PIECES.len()]),
        }
        if next() < 8 {
            let at = usize::from(next()) % made.len();
            made[at] ^= 1 << (next() % 8);
        }
    }
    made
}
