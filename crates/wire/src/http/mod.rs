//! The packets of a vehicle that answers requests over HTTP: what is asked, on which lane, and what comes
//! back.
//!
//! A protocol's calls are its own ([`HttpCall`]). The port sends what a call says, and knows nothing of its
//! meaning.

pub mod command_answers;
pub mod lanes;
pub mod motion;
pub mod received;
pub mod request;

pub use command_answers::CommandAnswers;
pub use lanes::Lanes;
pub use received::Received;
pub use request::{HttpCall, Lane, Method, Request};
