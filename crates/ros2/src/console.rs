//! The connections to the console.

pub mod api;

pub mod line;
pub mod request;
pub mod socket;

pub mod backoff;
