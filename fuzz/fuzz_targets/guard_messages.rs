//! Any bytes for the target `guard_messages`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::run("guard_messages", bytes));
