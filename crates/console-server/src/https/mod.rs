//! The console over HTTPS.
//!
//! ```text
//! connection -> accept: TLS?  -- identity: the certificate for the address that was reached
//!                 |                  given (PEM files), or issued by the program's own authority
//!                 +-- plain HTTP: "use https://", nothing else
//! ```
//! `trust` shows the authority to a device that does not know it yet.

mod authority;
mod given;

mod identity;

mod accept;
pub(super) mod trust;

pub(super) use accept::{Accepted, accept};
pub use given::CertificateFiles;
pub(super) use identity::Identity;
