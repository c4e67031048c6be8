//! Any bytes for the target `tracking_camera`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("tracking_camera", bytes));
