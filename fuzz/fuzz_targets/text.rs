//! Any bytes for the target `text`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::text::parse(bytes));
