//! Who may use the console: tokens, and the cookies that a page gets for its token.
//!
//! There are two tokens, one for control and one for watching. A page exchanges the token of its link for a
//! cookie; a program sends the token with each request (`Authorization: Bearer`). Tokens and cookies are
//! never logged.

use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

use barrelman_host::clock::Clock;
use barrelman_vocab::Timestamp;

use super::limits::{REQUESTS, RateLimit};
use super::origin::{Origin, Scheme};
use super::tokens::{Tokens, TokensInForce, is_equal, secret};

/// Largest number of cookies of each role. A further one takes the place of the oldest of its role: a watcher
/// cannot log a controller out.
const MAX_COOKIES: usize = 256;

/// What a token permits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// To see everything, and to stop.
    Watch,
    /// Everything.
    Control,
}

/// What a client has shown, and what it permits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pass {
    /// What it permits.
    pub(super) role: Role,
    proof: Proof,
}

impl Pass {
    /// Whether it is a cookie, that of a browser.
    pub(super) const fn is_cookie(&self) -> bool {
        matches!(self.proof, Proof::Cookie(_))
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Proof {
    /// Nothing is asked for.
    NotAsked,
    /// The token of a generation.
    Token(u64),
    Cookie(String),
}

/// The rule of who may use the console.
pub struct Access {
    cookie_name: String,
    /// Whether browsers may send the cookies over an encrypted connection only.
    is_encrypted: bool,
    secrets: Mutex<Secrets>,
    clock: Clock,
    /// Requests over HTTP with the watch token, and with the control token. A watcher who opens many
    /// connections has one limit, which is not the operator's.
    requests: Mutex<[RateLimit; 2]>,
}

/// The tokens and the cookies in force.
struct Secrets {
    /// Without tokens everybody may control.
    tokens: TokensInForce,
    /// How often the tokens were renewed.
    generation: u64,
    cookies: BTreeMap<String, (u64, Role)>,
    issued: u64,
    /// Cookies that the latest renewal by age has ended. They still stop the camera.
    ended_by_age: BTreeSet<String>,
}

impl Secrets {
    /// Replaces the tokens. Returns the cookies that end: all but those of `kept`.
    fn replace(&mut self, tokens: Tokens, kept: &[Pass]) -> BTreeSet<String> {
        self.tokens.replace(tokens);
        if !kept.iter().any(|pass| matches!(pass.proof, Proof::Token(_))) {
            self.generation += 1;
        }
        let is_kept = |value: &String| {
            kept.iter().any(|pass| matches!(&pass.proof, Proof::Cookie(cookie) if cookie == value))
        };
        let (kept, ended) =
            std::mem::take(&mut self.cookies).into_iter().partition(|(value, _)| is_kept(value));
        self.cookies = kept;
        BTreeMap::into_keys(ended).collect()
    }
}

impl Access {
    /// The rule of a server. Cookies do not differ by port, therefore the port is part of the cookie's name.
    pub(super) fn new(tokens: TokensInForce, origin: Origin, clock: Clock) -> Self {
        let limit = || RateLimit::new(REQUESTS, clock.now());
        Self {
            cookie_name: format!("barrelman-{}", origin.address.port()),
            is_encrypted: origin.scheme == Scheme::Https,
            secrets: Mutex::new(Secrets {
                tokens,
                generation: 0,
                cookies: BTreeMap::new(),
                issued: 0,
                ended_by_age: BTreeSet::new(),
            }),
            clock,
            requests: Mutex::new([limit(), limit()]),
        }
    }

    /// Whether a request over HTTP is within the limit of all requests with this role. `weight`: what it
    /// counts as.
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
        self.pass(authorization, cookies).map(|pass| pass.role)
    }

    /// What a request shows, by its `Authorization` and `Cookie` headers. `None`: nothing that permits
    /// anything.
    pub(super) fn pass(&self, authorization: Option<&str>, cookies: Option<&str>) -> Option<Pass> {
        let secrets = self.secrets();
        let role = match &*secrets.tokens.in_force() {
            Some(tokens) => authorization.and_then(|text| bearer_role(tokens, text)),
            None => return Some(Pass { role: Role::Control, proof: Proof::NotAsked }),
        };
        if let Some(role) = role {
            return Some(Pass { role, proof: Proof::Token(secrets.generation) });
        }
        self.values(cookies?).find_map(|value| {
            let (_, role) = secrets.cookies.get(value)?;
            Some(Pass { role: *role, proof: Proof::Cookie(value.to_owned()) })
        })
    }

    /// Whether a request shows, by its `Cookie` header, a cookie that the latest renewal by age has ended:
    /// who slept through the renewal may still stop.
    pub(super) fn may_still_stop(&self, cookies: Option<&str>) -> bool {
        let secrets = self.secrets();
        cookies.is_some_and(|cookies| self.values(cookies).any(|value| secrets.ended_by_age.contains(value)))
    }

    /// The values of this console's cookies in a `Cookie` header.
    fn values<'a>(&'a self, cookies: &'a str) -> impl Iterator<Item = &'a str> {
        let pairs = cookies.split(';').filter_map(|pair| pair.trim().split_once('='));
        pairs.filter(|(name, _)| *name == self.cookie_name).map(|(_, value)| value)
    }

    /// The role of an `Authorization` header with a token.
    pub fn bearer_role(&self, authorization: &str) -> Option<Role> {
        bearer_role(self.secrets().tokens.in_force().as_ref()?, authorization)
    }

    /// Whether a token is asked for.
    pub(super) fn asks_for_tokens(&self) -> bool {
        self.secrets().tokens.are_asked_for()
    }

    /// Whether what was shown is still in force.
    pub(super) fn holds(&self, pass: &Pass) -> bool {
        let secrets = self.secrets();
        match &pass.proof {
            Proof::NotAsked => true,
            Proof::Token(generation) => *generation == secrets.generation,
            Proof::Cookie(value) => secrets.cookies.contains_key(value),
        }
    }

    /// Ends the cookie of a pass. Returns whether the pass has one: a token holds until it is renewed.
    pub(super) fn revoke(&self, pass: &Pass) -> bool {
        match &pass.proof {
            Proof::Cookie(value) => {
                self.secrets().cookies.remove(value);
                true
            }
            Proof::Token(_) | Proof::NotAsked => false,
        }
    }

    /// Replaces the tokens. Of the cookies, those of `kept` stay. The old tokens open nothing any more;
    /// sockets that were opened with them stay where `kept` names one.
    pub(super) fn renew(&self, tokens: Tokens, kept: &[Pass]) {
        let mut secrets = self.secrets();
        secrets.replace(tokens, kept);
        secrets.ended_by_age.clear();
    }

    /// The same because `old` tokens are too old, unless others have taken their place: returns whether they
    /// are replaced. The cookies that end still stop the camera, until the next renewal.
    pub(super) fn renew_by_age(&self, old: &Tokens, tokens: Tokens, kept: &[Pass]) -> bool {
        let mut secrets = self.secrets();
        let is_old = secrets.tokens.in_force().as_ref() == Some(old);
        if is_old {
            secrets.ended_by_age = secrets.replace(tokens, kept);
        }
        is_old
    }

    /// The value of a `Set-Cookie` header for a page with this role.
    ///
    /// # Errors
    /// If the system has no random numbers.
    pub fn new_cookie(&self, role: Role) -> io::Result<String> {
        let value = secret()?;
        let mut secrets = self.secrets();
        let of_role = secrets.cookies.iter().filter(|(_, (_, of))| *of == role);
        if of_role.clone().count() >= MAX_COOKIES {
            let oldest = of_role.min_by_key(|(_, (issued, _))| *issued);
            if let Some(oldest) = oldest.map(|(value, _)| value.clone()) {
                secrets.cookies.remove(&oldest);
            }
        }
        let issued = secrets.issued;
        secrets.issued += 1;
        secrets.cookies.insert(value.clone(), (issued, role));
        let secure = if self.is_encrypted { "; Secure" } else { "" };
        Ok(format!("{}={value}; Path=/; HttpOnly; SameSite=Strict; Max-Age=604800{secure}", self.cookie_name))
    }

    /// The tokens, if tokens are asked for.
    pub fn tokens(&self) -> Option<Tokens> {
        self.secrets().tokens.get()
    }

    fn secrets(&self) -> MutexGuard<'_, Secrets> {
        self.secrets.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The role of an `Authorization` header with one of these tokens.
fn bearer_role(tokens: &Tokens, authorization: &str) -> Option<Role> {
    let given = authorization.strip_prefix("Bearer ")?.trim();
    if is_equal(given, &tokens.control) {
        Some(Role::Control)
    } else if is_equal(given, &tokens.watch) {
        Some(Role::Watch)
    } else {
        None
    }
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
        Access::new(TokensInForce::new(Some(tokens)), origin(Scheme::Http), Clock::start())
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
        let open = Access::new(TokensInForce::default(), origin(Scheme::Http), Clock::start());
        assert_eq!(open.role(None, None), Some(Role::Control));
    }

    #[test]
    fn a_cookie_carries_the_role_of_its_token() {
        let access = access();
        let cookie = access.new_cookie(Role::Watch).unwrap();
        assert!(cookie.contains("HttpOnly") && cookie.contains("SameSite=Strict"));
        let encrypted = Access::new(TokensInForce::default(), origin(Scheme::Https), Clock::start());
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
        assert_eq!(access.secrets().cookies.len(), MAX_COOKIES);
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
    fn renewed_tokens_end_the_old_ones_and_all_cookies_but_the_kept_ones() {
        let access = access();
        let page = || {
            let cookie = access.new_cookie(Role::Control).unwrap();
            let pair = cookie.split(';').next().unwrap().to_owned();
            (access.pass(None, Some(&pair)).unwrap(), pair)
        };
        let ((kept, kept_pair), (other, other_pair)) = (page(), page());
        let program = access.pass(Some("Bearer watch-0123456789"), None).unwrap();
        assert!([&kept, &other, &program].iter().all(|pass| access.holds(pass)));
        let tokens =
            Tokens { control: "control-new-345678".to_owned(), watch: "watch-new-345678".to_owned() };
        access.renew(tokens, std::slice::from_ref(&kept));
        assert!(access.holds(&kept) && !access.holds(&other) && !access.holds(&program));
        assert_eq!(access.role(Some("Bearer control-0123456789"), None), None);
        assert_eq!(access.role(Some("Bearer watch-new-345678"), None), Some(Role::Watch));
        assert_eq!(access.role(None, Some(&kept_pair)), Some(Role::Control));
        assert_eq!(access.role(None, Some(&other_pair)), None);
        assert!(access.revoke(&kept) && !access.revoke(&program));
        assert!(!access.holds(&kept) && access.role(None, Some(&kept_pair)).is_none());
    }

    #[test]
    fn a_cookie_that_a_renewal_by_age_has_ended_still_stops_and_does_nothing_else() {
        let access = access();
        let cookie = access.new_cookie(Role::Control).unwrap();
        let pair = Some(cookie.split(';').next().unwrap());
        assert!(!access.may_still_stop(pair), "it permits more");
        let tokens = |name: &str| Tokens {
            control: format!("control-{name}-345678"),
            watch: format!("watch-{name}-345678"),
        };
        let first = access.tokens().unwrap();
        assert!(access.renew_by_age(&first, tokens("second"), &[]));
        assert!(access.may_still_stop(pair) && access.role(None, pair).is_none());
        assert!(!access.may_still_stop(None) && !access.may_still_stop(Some("barrelman-8480=guess")));
        assert!(!access.renew_by_age(&first, tokens("third"), &[]), "others have taken their place");
        assert!(access.tokens().unwrap() == tokens("second"));
        access.renew(tokens("fourth"), &[]);
        assert!(!access.may_still_stop(pair), "new links end it");
    }
}
