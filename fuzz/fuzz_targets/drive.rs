//! Any bytes for the target `drive`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("drive", bytes));
