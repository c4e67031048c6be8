//! The `barrelman` program.

fn main() {}
