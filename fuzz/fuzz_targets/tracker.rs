//! Any bytes are a session in front of both trackers: neither panics, and what they say is in order.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| barrelman_fuzz::tracker::session(bytes));
