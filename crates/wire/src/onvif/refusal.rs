//! What a refusal of a camera means.

use barrelman_vocab::acceptance::Acceptance;

use super::answers::{Fault, FaultBody};
use super::soap;

/// What an answer that is no answer to the question says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// What it means.
    pub said: Acceptance,
    /// Whether the camera does not know the question.
    pub is_unknown: bool,
    /// The camera's words, as far as it has any.
    pub words: String,
}

impl Refusal {
    /// Reads the status and the body of an answer; `None`: it is no refusal.
    pub fn of(status: u16, body: &[u8]) -> Option<Self> {
        let fault = soap::read::<FaultBody>(body).map(|body| body.fault);
        if fault.is_none() && (200..300).contains(&status) {
            return None;
        }
        let names =
            |name: &str| fault.as_ref().is_some_and(|fault| fault.code.names().any(|one| one == name));
        let is_unknown =
            status == 404 || names("ActionNotSupported") || names("NotImplemented") || names("UnknownAction");
        let said = if matches!(status, 401 | 403) || names("NotAuthorized") || names("FailedAuthentication") {
            Acceptance::LoginRefused
        } else if is_unknown || names("InvalidArgVal") || names("NoProfile") {
            Acceptance::Unusable
        } else if status == 503 {
            Acceptance::NotReady
        } else {
            Acceptance::Fault
        };
        let words = fault.as_ref().map_or_else(|| format!("status {status}"), words);
        Some(Self { said, is_unknown, words })
    }
}

/// The words of a refusal, bounded and without control characters.
fn words(fault: &Fault) -> String {
    let text = fault.reason.as_ref().and_then(|reason| reason.texts.first());
    let words = text.map(|text| text.words.trim()).filter(|words| !words.is_empty());
    let words = words.or_else(|| fault.code.names().last()).unwrap_or_default();
    words.chars().filter(|c| !c.is_control()).take(160).collect()
}
