//! What a refusal of a camera means.

use barrelman_vocab::acceptance::Acceptance;
use serde::Deserialize;

use super::soap;

/// What an answer that is no answer to the question says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// What it means.
    pub said: Acceptance,
    /// Whether the camera does not know the question.
    pub is_unknown: bool,
    /// Whether the camera has no such media profile any more.
    pub lacks_profile: bool,
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
        Some(Self { said, is_unknown, lacks_profile: names("NoProfile"), words })
    }
}

/// The words of a refusal, bounded and without control characters.
fn words(fault: &Fault) -> String {
    let text = fault.reason.as_ref().and_then(|reason| reason.texts.first());
    let words = text.map(|text| text.words.trim()).filter(|words| !words.is_empty());
    let words = words.or_else(|| fault.code.names().last()).unwrap_or_default();
    words.chars().filter(|c| !c.is_control()).take(160).collect()
}

/// The body of a refusal.
#[derive(Debug, Deserialize)]
struct FaultBody {
    /// The refusal.
    #[serde(rename = "Fault")]
    fault: Fault,
}

/// A refusal.
#[derive(Debug, Deserialize)]
struct Fault {
    /// Its code.
    #[serde(rename = "Code")]
    code: FaultCode,
    /// What it says in words.
    #[serde(rename = "Reason")]
    reason: Option<FaultReason>,
}

/// What a refusal says in words.
#[derive(Debug, Deserialize)]
struct FaultReason {
    /// The words, in one or several languages.
    #[serde(rename = "Text", default)]
    texts: Vec<FaultText>,
}

/// A text in a language.
#[derive(Debug, Deserialize)]
struct FaultText {
    /// The words.
    #[serde(rename = "$text", default)]
    words: String,
}

/// The code of a refusal. It has at most these three parts.
#[derive(Debug, Deserialize)]
struct FaultCode {
    /// A name with a prefix.
    #[serde(rename = "Value")]
    value: String,
    #[serde(rename = "Subcode")]
    within: Option<Subcode>,
}

#[derive(Debug, Deserialize)]
struct Subcode {
    #[serde(rename = "Value")]
    value: String,
    #[serde(rename = "Subcode")]
    within: Option<InnerSubcode>,
}

#[derive(Debug, Deserialize)]
struct InnerSubcode {
    #[serde(rename = "Value")]
    value: String,
}

impl FaultCode {
    /// The names, without their prefixes, from the widest to the narrowest.
    fn names(&self) -> impl Iterator<Item = &str> {
        let within = self.within.as_ref();
        let inner = within.and_then(|code| code.within.as_ref());
        let values = [Some(&self.value), within.map(|code| &code.value), inner.map(|code| &code.value)];
        values.into_iter().flatten().map(|value| value.rsplit(':').next().unwrap_or_default().trim())
    }
}
