//! User and password of a camera.

use std::fmt;

/// User and password of a camera. Their values are not printed.
#[derive(Clone, PartialEq, Eq)]
pub struct Login {
    /// The user's name.
    pub user: String,
    /// The password.
    pub password: String,
    /// Whether the password may be sent as it is (Basic): in TLS, or where the configuration permits it.
    pub permits_basic: bool,
}

impl Login {
    /// Reads `user:password`. The password may be empty and may contain colons.
    ///
    /// # Errors
    /// A text without a user or without a colon. The message does not repeat the text.
    pub fn parse(text: &str) -> Result<Self, LoginError> {
        let (user, password) = text.split_once(':').filter(|(user, _)| !user.is_empty()).ok_or(LoginError)?;
        Ok(Self { user: user.to_owned(), password: password.to_owned(), permits_basic: false })
    }
}

/// A text that is not a login.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("there is no login: write user:password")]
pub struct LoginError;

impl fmt::Debug for Login {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Login(***)")
    }
}
