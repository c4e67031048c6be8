//! Any bytes for the target `y4m`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("y4m", bytes));
