//! Any bytes for the target `rtp`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("rtp", bytes));
