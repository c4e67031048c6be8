//! Any bytes for the target `urls`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("urls", bytes));
