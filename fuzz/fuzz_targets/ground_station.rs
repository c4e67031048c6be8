//! Any bytes for the target `ground_station`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("ground_station", bytes));
