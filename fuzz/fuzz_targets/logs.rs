//! Any bytes for the target `logs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("logs", bytes));
