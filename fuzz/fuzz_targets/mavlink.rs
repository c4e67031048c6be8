//! Any bytes for the target `mavlink`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("mavlink", bytes));
