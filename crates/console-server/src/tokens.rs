//! The two tokens of a console, one for control and one for watching, and the file that keeps them.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, SystemTime};

use anyhow::{Context, Result, bail};
use barrelman_host::input::{self, is_readable_by_others};
use barrelman_host::output::OutputFile;
use barrelman_host::random::random_bytes;
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::{Deserialize, Serialize};

/// Length of a token that the program makes, and of a cookie, bytes before the encoding.
const SECRET_BYTES: usize = 16;
/// Shortest token in a file, characters.
const MIN_TOKEN_CHARS: usize = 16;

/// Where tokens are kept, and for how long.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct KeptTokens {
    /// The file; `None`: they are made for this program's life.
    pub file: Option<PathBuf>,
    /// The age at which they are renewed; `None`: never.
    pub max_age: Option<Duration>,
}

impl KeptTokens {
    /// The tokens of the file, or new ones.
    ///
    /// # Errors
    /// If the tokens cannot be read or made, or would be renewed without a file in which the new ones can be
    /// found.
    pub fn take(&self) -> Result<Tokens> {
        match &self.file {
            Some(path) => Tokens::kept_in(path, self.max_age),
            None if self.max_age.is_some() => bail!(
                "tokens that are renewed need a file in which the new ones are found: give --console-token-file, or \
                 console.token_file"
            ),
            None => Tokens::random().context("no random numbers for the console's tokens"),
        }
    }
}

/// The two tokens of a session.
#[derive(Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tokens {
    /// For control.
    pub control: String,
    /// For watching.
    pub watch: String,
}

impl Tokens {
    /// New random tokens.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn random() -> io::Result<Self> {
        Ok(Self { control: secret()?, watch: secret()? })
    }

    /// The tokens of a file. Where it is missing or empty, or its tokens are older than `max_age`, it is made
    /// with new tokens, for its owner alone.
    ///
    /// # Errors
    /// As [`Self::read`], and if the file cannot be made.
    pub fn kept_in(path: &Path, max_age: Option<Duration>) -> Result<Self> {
        if has_content(path) && max_age.is_none_or(|max_age| age_of(path) < max_age) {
            return Self::read(path);
        }
        let tokens = Self::random().context("no random numbers for the console's tokens")?;
        tokens.keep_in(path)?;
        tracing::info!("the console's tokens were made, and are kept in {}", path.display());
        Ok(tokens)
    }

    /// Keeps the tokens in a file, in place of those that it has.
    ///
    /// # Errors
    /// If the file cannot be made.
    pub fn keep_in(&self, path: &Path) -> Result<()> {
        let context = || format!("the console's tokens cannot be kept in {}", path.display());
        let file = OutputFile::open(path, true).with_context(context)?;
        file.write_whole(format!("{}\n{}\n", self.control, self.watch).as_bytes()).with_context(context)
    }

    /// Reads the tokens from a file of two lines: control, watch.
    ///
    /// # Errors
    /// If the file cannot be read, or a line is no usable token. The message repeats nothing of the content.
    pub fn read(path: &Path) -> Result<Self> {
        if is_readable_by_others(path) {
            let path = path.display();
            tracing::warn!("the token file {path} can be read by others: run `chmod 600 {path}`");
        }
        let text = String::from_utf8(input::read(path)?).context("it is not UTF-8 text");
        text.and_then(|text| Self::parse(&text))
            .with_context(|| format!("the token file {} is not usable", path.display()))
    }

    fn parse(text: &str) -> Result<Self> {
        let mut lines = text.lines().map(str::trim);
        let mut token = |what: &str| {
            let token = lines.next().unwrap_or_default().to_owned();
            let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_.~".contains(c);
            if token.len() < MIN_TOKEN_CHARS || !token.chars().all(is_plain) {
                bail!(
                    "the {what} token must be at least {MIN_TOKEN_CHARS} letters, digits, or - _ . ~: \
                     give two lines, the control token and the watch token"
                );
            }
            Ok(token)
        };
        let tokens = Self { control: token("control")?, watch: token("watch")? };
        if tokens.control == tokens.watch {
            bail!("both tokens are the same: a watcher could control");
        }
        Ok(tokens)
    }
}

/// The tokens in force. A renewal replaces them for all who look at them.
#[derive(Clone, Default)]
pub struct TokensInForce(Arc<Mutex<Option<Tokens>>>);

impl TokensInForce {
    /// `None`: no token is asked for.
    pub fn new(tokens: Option<Tokens>) -> Self {
        Self(Arc::new(Mutex::new(tokens)))
    }

    /// The tokens; `None`: no token is asked for.
    pub fn get(&self) -> Option<Tokens> {
        self.in_force().clone()
    }

    /// Whether a token is asked for.
    pub fn are_asked_for(&self) -> bool {
        self.in_force().is_some()
    }

    /// Whether this is the token for watching; `None`: whether no token is asked for.
    pub fn is_watch(&self, given: Option<&str>) -> bool {
        match (&*self.in_force(), given) {
            (Some(tokens), Some(given)) => is_equal(given, &tokens.watch),
            (tokens, given) => tokens.is_none() && given.is_none(),
        }
    }

    /// Whether this is one of the tokens.
    pub(super) fn opens(&self, given: &str) -> bool {
        self.in_force().as_ref().is_some_and(|tokens| {
            // Both are compared, whichever it is.
            is_equal(given, &tokens.control) | is_equal(given, &tokens.watch)
        })
    }

    /// The tokens in place. A reader holds up the others, and a renewal.
    pub(super) fn in_force(&self) -> MutexGuard<'_, Option<Tokens>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn replace(&self, tokens: Tokens) {
        *self.in_force() = Some(tokens);
    }
}

impl fmt::Debug for TokensInForce {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("TokensInForce")
    }
}

/// Compares two texts in a time that does not depend on where they differ.
pub(super) fn is_equal(a: &str, b: &str) -> bool {
    let difference = a.bytes().zip(b.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    a.len() == b.len() && difference == 0
}

/// Whether there is a file that is not empty: a power cut can leave an empty one. A pipe has no size.
fn has_content(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| !found.is_file() || found.len() > 0)
}

/// How long ago a file was written.
pub(super) fn age_of(path: &Path) -> Duration {
    let written = std::fs::metadata(path).and_then(|metadata| metadata.modified());
    written.ok().and_then(|written| SystemTime::now().duration_since(written).ok()).unwrap_or_default()
}

/// Random text for a token or a cookie.
pub(super) fn secret() -> io::Result<String> {
    let mut bytes = [0; SECRET_BYTES];
    random_bytes(&mut bytes)?;
    Ok(URL_SAFE_NO_PAD.encode(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_file_needs_two_different_usable_lines() {
        assert!(Tokens::parse("control-0123456789\nwatch-0123456789\n").is_ok());
        for text in
            ["", "short\nwatch-0123456789", "control-0123456789", "same-0123456789ab\nsame-0123456789ab"]
        {
            let error = Tokens::parse(text).err().expect(text);
            assert!(!format!("{error:#}").contains("0123"), "the content is not repeated");
        }
    }

    #[test]
    fn tokens_are_made_once_and_kept_for_their_owner_alone() {
        let folder = std::env::temp_dir().join(format!("barrelman-kept-tokens-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("tokens");
        let first = Tokens::kept_in(&path, None).unwrap();
        assert!(!is_readable_by_others(&path));
        let again = Tokens::kept_in(&path, Some(Duration::from_secs(3600))).unwrap();
        assert!(first == again && first.control != first.watch);
        assert!(Tokens::kept_in(&path, Some(Duration::ZERO)).unwrap() != first, "old tokens are replaced");
        assert!(!is_readable_by_others(&path));
        std::fs::write(&path, "short\n").unwrap();
        assert!(Tokens::kept_in(&path, None).is_err(), "a file that is there is not replaced");
        std::fs::write(&path, "").unwrap();
        let made = Tokens::kept_in(&path, None).unwrap();
        assert!(Tokens::read(&path).unwrap() == made, "what a power cut has left is replaced");
        let nowhere = Tokens::kept_in(&folder.join("missing/tokens"), None).err().unwrap();
        assert!(format!("{nowhere:#}").contains("missing/tokens"), "{nowhere:#}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
