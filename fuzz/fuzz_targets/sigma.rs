//! Any bytes for the target `sigma`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("sigma", bytes));
