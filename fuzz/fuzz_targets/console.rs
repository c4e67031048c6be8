//! Any bytes for the target `console`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("console", bytes));
