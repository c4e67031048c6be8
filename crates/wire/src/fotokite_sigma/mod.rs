//! The Fotokite Sigma's web API, version 1.1.2. `docs/wire/fotokite-sigma.md` describes what is used of it.
//!
//! [`FotokiteSigmaSession`] is the client: control, rates, telemetry, shut-down. [`Sigma`] is the other end,
//! for the emulator and the tests. Both are plain structs without sockets and clocks: requests, answers and
//! times in and out.

pub mod call;
pub mod json;
pub mod speeds;
pub mod zoom;

pub mod control;
pub mod reports;
pub mod schedule;
pub mod session;

pub mod sigma;

pub use call::Call;
pub use session::FotokiteSigmaSession;
pub use sigma::Sigma;
