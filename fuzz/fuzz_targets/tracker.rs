//! Any bytes for the target `tracker`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("tracker", bytes));
