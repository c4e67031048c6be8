//! Any bytes for the target `scenario`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("scenario", bytes));
