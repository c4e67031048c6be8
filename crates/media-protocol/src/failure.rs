//! Why a source cannot go on, in plain words, with what to do.

use serde::{Deserialize, Serialize};

/// Why a source cannot go on.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFailure {
    /// What is wrong, with a verb: "does not let us in".
    pub what: String,
    /// What to do; empty: nothing but to try again.
    pub remedy: String,
    /// Whether another attempt cannot succeed.
    pub is_final: bool,
}

/// A failure that another attempt may overcome.
pub fn temporary(what: impl Into<String>, remedy: impl Into<String>) -> SourceFailure {
    SourceFailure { what: what.into(), remedy: remedy.into(), is_final: false }
}

/// A failure that another attempt cannot overcome.
pub fn permanent(what: impl Into<String>, remedy: impl Into<String>) -> SourceFailure {
    SourceFailure { what: what.into(), remedy: remedy.into(), is_final: true }
}

/// What a server's status says (RFC 2326, 7.1.1; RFC 9110, 15).
pub fn from_status(status: u16) -> Option<SourceFailure> {
    Some(match status {
        300..=399 => permanent(
            "leads to another address (a redirect), which is not followed",
            "Give the address of the stream itself with --video",
        ),
        401 | 403 | 407 => permanent(
            "does not let us in",
            "Write USER:PASSWORD on the first line of a file and give --video-login-file FILE, or name the file as \
             video.login_file in the configuration",
        ),
        // A server that is still starting knows its streams later.
        404 | 410 => temporary(
            "has no stream of this name",
            "Check the path in the address: the camera's manual or its page names it",
        ),
        406 | 415 => permanent("does not offer this stream in a form that is read here", OTHER_PROFILE),
        453 => temporary("has not enough bandwidth for one more viewer", FEWER_VIEWERS),
        454 => temporary("has ended the session", ""),
        461 => {
            permanent("does not send its packets this way", "Choose another transport: TCP, UDP or multicast")
        }
        503 => temporary("is busy, or has too many viewers", FEWER_VIEWERS),
        400..=499 => permanent(format!("refuses the request (status {status})"), OTHER_PROFILE),
        500..=599 => temporary(format!("has a fault of its own (status {status})"), RESTART),
        _ => return None,
    })
}

const OTHER_PROFILE: &str =
    "Set this profile of the camera to H.264 or H.265, or give the address of another one";
const FEWER_VIEWERS: &str = "Close other programs that show this stream";
const RESTART: &str = "If this stays, restart the camera";
