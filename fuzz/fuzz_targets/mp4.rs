//! Any bytes for the target `mp4`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("mp4", bytes));
