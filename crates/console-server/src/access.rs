//! Who may use the console: tokens, and the cookies that a page gets for its token.
//!
//! There are two tokens, one for control and one for watching. A page exchanges the token of its link for a cookie; a
//! program sends the token with each request (`Authorization: Bearer`). Tokens and cookies are never logged.

use std::collections::BTreeMap;
use std::io::{self, Write as _};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use anyhow::{Context, Result, bail};
use barrelman_host::clock::Clock;
use barrelman_host::input::{self, is_readable_by_others};
use barrelman_host::output::OutputFile;
use barrelman_host::random::random_bytes;
use barrelman_vocab::Timestamp;
use base64::Engine as _;
use base64::engine::general_purpose::URL_SAFE_NO_PAD;
use serde::{Deserialize, Serialize};

use super::limits::{REQUESTS, RateLimit};
use super::origin::{Origin, Scheme};

/// Length of a token that the program makes, and of a cookie, bytes before the encoding.
const SECRET_BYTES: usize = 16;
/// Shortest token in a file, characters.
const MIN_TOKEN_CHARS: usize = 16;
/// Largest number of cookies of each role. A further one takes the place of the oldest of its role: a watcher cannot log
/// a controller out.
const MAX_COOKIES: usize = 256;

/// What a token permits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// To see everything, and to stop.
    Watch,
    /// Everything.
    Control,
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

    /// The tokens of a file, which is made with new tokens, for its owner alone, where it is missing.
    ///
    /// # Errors
    /// As [`Self::read`], and if the file cannot be made.
    pub fn kept_in(path: &Path) -> Result<Self> {
        if path.exists() {
            return Self::read(path);
        }
        let context = || format!("the console's tokens cannot be kept in {}", path.display());
        let tokens = Self::random().with_context(context)?;
        let mut file = OutputFile::open(path, false).with_context(context)?;
        file.write_all(tokens.lines().as_bytes()).with_context(context)?;
        tracing::info!("the console's tokens were made, and are kept in {}", path.display());
        Ok(tokens)
    }

    fn lines(&self) -> String {
        format!("{}\n{}\n", self.control, self.watch)
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

/// Random text for a token or a cookie.
fn secret() -> io::Result<String> {
    let mut bytes = [0; SECRET_BYTES];
    random_bytes(&mut bytes)?;
    Ok(URL_SAFE_NO_PAD.encode(bytes))
}

/// The rule of who may use the console.
pub struct Access {
    /// `None`: no token is asked for, and everybody may control.
    tokens: Option<Tokens>,
    cookie_name: String,
    /// Whether browsers may send the cookies over an encrypted connection only.
    is_encrypted: bool,
    cookies: Mutex<Cookies>,
    clock: Clock,
    /// Requests over HTTP with the watch token, and with the control token. A watcher who opens many connections has one
    /// limit, which is not the operator's.
    requests: Mutex<[RateLimit; 2]>,
}

#[derive(Default)]
struct Cookies {
    roles: BTreeMap<String, (u64, Role)>,
    issued: u64,
}

impl Access {
    /// The rule of a server. Cookies do not differ by port, therefore the port is part of the cookie's name.
    pub(super) fn new(tokens: Option<Tokens>, origin: Origin, clock: Clock) -> Self {
        let limit = || RateLimit::new(REQUESTS, clock.now());
        Self {
            tokens,
            cookie_name: format!("barrelman-{}", origin.address.port()),
            is_encrypted: origin.scheme == Scheme::Https,
            cookies: Mutex::default(),
            clock,
            requests: Mutex::new([limit(), limit()]),
        }
    }

    /// Whether a request over HTTP is within the limit of all requests with this role. `weight`: what it counts as.
    pub fn permits_request(&self, role: Role, weight: f64, now: Timestamp) -> bool {
        let mut limits = self.requests.lock().unwrap_or_else(PoisonError::into_inner);
        let limit = match role {
            Role::Watch => &mut limits[0],
            Role::Control => &mut limits[1],
        };
        limit.takes(weight, now)
    }

    /// The program's clock.
    pub const fn clock(&self) -> Clock {
        self.clock
    }

    /// What a request may do, by its `Authorization` and `Cookie` headers. `None`: nothing.
    pub fn role(&self, authorization: Option<&str>, cookies: Option<&str>) -> Option<Role> {
        if self.tokens.is_none() {
            return Some(Role::Control);
        }
        authorization.and_then(|text| self.bearer_role(text)).or_else(|| {
            let found = cookies?.split(';').filter_map(|pair| pair.trim().split_once('='));
            found
                .filter(|(name, _)| *name == self.cookie_name)
                .find_map(|(_, value)| self.cookies().roles.get(value).map(|(_, role)| *role))
        })
    }

    /// The role of an `Authorization` header with a token.
    pub fn bearer_role(&self, authorization: &str) -> Option<Role> {
        let given = authorization.strip_prefix("Bearer ")?.trim();
        let tokens = self.tokens.as_ref()?;
        if is_equal(given, &tokens.control) {
            Some(Role::Control)
        } else if is_equal(given, &tokens.watch) {
            Some(Role::Watch)
        } else {
            None
        }
    }

    /// The value of a `Set-Cookie` header for a page with this role.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn new_cookie(&self, role: Role) -> io::Result<String> {
        let value = secret()?;
        let mut cookies = self.cookies();
        let of_role = cookies.roles.iter().filter(|(_, (_, of))| *of == role);
        if of_role.clone().count() >= MAX_COOKIES {
            let oldest = of_role.min_by_key(|(_, (issued, _))| *issued);
            if let Some(oldest) = oldest.map(|(value, _)| value.clone()) {
                cookies.roles.remove(&oldest);
            }
        }
        let issued = cookies.issued;
        cookies.issued += 1;
        cookies.roles.insert(value.clone(), (issued, role));
        let secure = if self.is_encrypted { "; Secure" } else { "" };
        Ok(format!("{}={value}; Path=/; HttpOnly; SameSite=Strict; Max-Age=604800{secure}", self.cookie_name))
    }

    /// The tokens, if tokens are asked for.
    pub const fn tokens(&self) -> Option<&Tokens> {
        self.tokens.as_ref()
    }

    fn cookies(&self) -> MutexGuard<'_, Cookies> {
        self.cookies.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Compares two texts in a time that does not depend on where they differ.
fn is_equal(a: &str, b: &str) -> bool {
    let difference = a.bytes().zip(b.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
    a.len() == b.len() && difference == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(scheme: Scheme) -> Origin {
        Origin { scheme, address: "127.0.0.1:8480".parse().unwrap() }
    }

    fn access() -> Access {
        let tokens =
            Tokens { control: "control-0123456789".to_owned(), watch: "watch-0123456789".to_owned() };
        Access::new(Some(tokens), origin(Scheme::Http), Clock::start())
    }

    #[test]
    fn each_token_has_its_role_and_nothing_else_has_one() {
        let access = access();
        for (header, role) in [
            ("Bearer control-0123456789", Some(Role::Control)),
            ("Bearer watch-0123456789", Some(Role::Watch)),
            ("Bearer control-012345678", None),
            ("Bearer ", None),
            ("control-0123456789", None),
            ("Basic control-0123456789", None),
        ] {
            assert_eq!(access.role(Some(header), None), role, "{header}");
        }
        assert_eq!(access.role(None, None), None);
        let open = Access::new(None, origin(Scheme::Http), Clock::start());
        assert_eq!(open.role(None, None), Some(Role::Control));
    }

    #[test]
    fn a_cookie_carries_the_role_of_its_token() {
        let access = access();
        let cookie = access.new_cookie(Role::Watch).unwrap();
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"));
        let encrypted = Access::new(None, origin(Scheme::Https), Clock::start());
        assert!(
            !cookie.contains("Secure") && encrypted.new_cookie(Role::Watch).unwrap().ends_with("; Secure")
        );
        let pair = cookie.split(';').next().unwrap();
        assert_eq!(access.role(None, Some(&format!("other=1; {pair}"))), Some(Role::Watch));
        assert_eq!(access.role(None, Some("barrelman-8480=guess")), None);
    }

    #[test]
    fn the_number_of_cookies_is_bounded_and_the_oldest_goes() {
        let access = access();
        let pair = |cookie: String| cookie.split(';').next().unwrap().to_owned();
        let first = pair(access.new_cookie(Role::Control).unwrap());
        let later: Vec<_> = (0..MAX_COOKIES).map(|_| access.new_cookie(Role::Control).unwrap()).collect();
        assert_eq!(access.role(None, Some(&first)), None);
        assert_eq!(access.role(None, Some(&pair(later[MAX_COOKIES - 1].clone()))), Some(Role::Control));
        assert_eq!(access.cookies().roles.len(), MAX_COOKIES);
    }

    #[test]
    fn cookies_of_one_role_take_no_place_of_the_other() {
        let access = access();
        let pair = |cookie: String| cookie.split(';').next().unwrap().to_owned();
        for (role, other) in [(Role::Control, Role::Watch), (Role::Watch, Role::Control)] {
            let first = pair(access.new_cookie(role).unwrap());
            for _ in 0..2 * MAX_COOKIES {
                access.new_cookie(other).unwrap();
            }
            assert_eq!(access.role(None, Some(&first)), Some(role), "{role:?}");
        }
    }

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
        let first = Tokens::kept_in(&path).unwrap();
        assert!(!is_readable_by_others(&path));
        let again = Tokens::kept_in(&path).unwrap();
        assert!(first == again && first.control != first.watch);
        std::fs::write(&path, "short\n").unwrap();
        assert!(Tokens::kept_in(&path).is_err(), "a file that is there is not replaced");
        let nowhere = Tokens::kept_in(&folder.join("missing/tokens")).err().unwrap();
        assert!(format!("{nowhere:#}").contains("missing/tokens"), "{nowhere:#}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
