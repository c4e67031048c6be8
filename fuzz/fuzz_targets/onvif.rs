//! Any bytes for the target `onvif`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("onvif", bytes));
