//! The program `barrelman-guard`: owns the port of a vehicle that keeps its last rate, and outlives
//! `barrelman run`.
//!
//! Only the crate `barrelman-link` may be named here, so that no decoder and no renderer is linked:
//! `xtask tidy` looks.

use std::process::ExitCode;

fn main() -> ExitCode {
    barrelman_link::guard::process::run()
}
