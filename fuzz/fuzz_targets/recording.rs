//! Any bytes for the target `recording`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("recording", bytes));
