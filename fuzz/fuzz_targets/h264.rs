//! Any bytes for the target `h264`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("h264", bytes));
