//! The links of a served console: where their tokens are kept, and how they are renewed.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::{Context as _, Result};
use barrelman_vocab::Timestamp;
use schemars::JsonSchema;
use serde::Serialize;

use super::access::{Access, Pass};
use super::links::link_to_page;
use super::links_file::{LinksFile, ServedConsole};
use super::origin::Origin;
use super::tokens::{KeptTokens, Tokens, age_of};

/// After a renewal that failed, the next attempt.
const RETRY: Duration = Duration::from_secs(600);

/// The links of a console. Without tokens both are its address.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Links")]
pub(super) struct LinksBody {
    /// For control.
    pub(super) control: String,
    /// For watching.
    pub(super) watch: String,
}

/// Where a console is, and where its tokens are kept.
pub(super) struct IssuedLinks {
    origin: Origin,
    /// SHA-256 of the console's own certificate authority.
    fingerprint: Option<String>,
    kept: KeptTokens,
    /// Where `barrelman links` finds them.
    links_file: Option<PathBuf>,
    state: Mutex<State>,
}

struct State {
    /// The file, while the console is served.
    published: Option<LinksFile>,
    /// When the tokens are too old; `None`: never.
    renew_at: Option<Timestamp>,
}

impl IssuedLinks {
    /// The links of a console that has its tokens. Writes nothing.
    pub(super) fn new(
        origin: Origin,
        fingerprint: Option<String>,
        kept: KeptTokens,
        links_file: Option<PathBuf>,
        now: Timestamp,
    ) -> Self {
        let age = kept.file.as_deref().map_or(Duration::ZERO, age_of);
        let renew_at = kept.max_age.map(|max_age| now.plus(max_age.saturating_sub(age)));
        let state = Mutex::new(State { published: None, renew_at });
        Self { origin, fingerprint, kept, links_file, state }
    }

    /// Writes the links for `barrelman links`, where they are wanted, in place of earlier ones.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn publish(&self, tokens: Option<Tokens>) -> Result<()> {
        let Some((path, tokens)) = self.links_file.as_ref().zip(tokens) else { return Ok(()) };
        let console = ServedConsole { origin: self.origin, tokens, fingerprint: self.fingerprint.clone() };
        let mut state = self.state();
        // The file of the earlier links holds the lock.
        state.published = None;
        state.published = Some(LinksFile::write(path, &console)?);
        Ok(())
    }

    /// Replaces the tokens, in their file first. Of the cookies, those of `pages` stay.
    ///
    /// # Errors
    /// If there are no random numbers, or the tokens cannot be kept: then the old ones stay. If the links
    /// cannot be published: then the new ones hold.
    pub(super) fn renew(&self, access: &Access, pages: &[Pass]) -> Result<()> {
        let now = access.clock().now();
        self.state().renew_at = self.kept.max_age.map(|_| now.plus(RETRY));
        let tokens = Tokens::random().context("no random numbers for the console's tokens")?;
        if let Some(file) = &self.kept.file {
            tokens.keep_in(file)?;
        }
        access.renew(tokens.clone(), pages);
        self.state().renew_at = self.kept.max_age.map(|max_age| now.plus(max_age));
        self.publish(Some(tokens))
    }

    /// When the tokens are too old; `None`: never.
    pub(super) fn due(&self) -> Option<Timestamp> {
        self.state().renew_at
    }

    /// The links in force.
    pub(super) fn body(&self, access: &Access) -> LinksBody {
        let tokens = access.tokens();
        let (control, watch) = tokens.map(|tokens| (tokens.control, tokens.watch)).unzip();
        LinksBody {
            control: link_to_page(self.origin, control.as_deref()),
            watch: link_to_page(self.origin, watch.as_deref()),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use barrelman_host::clock::Clock;

    use super::super::access::Role;
    use super::super::links_file;
    use super::super::origin::Scheme;
    use super::super::tokens::TokensInForce;
    use super::*;

    #[test]
    fn renewed_tokens_are_in_their_file_in_the_links_and_in_force() {
        let folder = std::env::temp_dir().join(format!("barrelman-issued-links-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let (file, published) = (folder.join("tokens"), folder.join("links"));
        let origin = Origin { scheme: Scheme::Http, address: "127.0.0.1:8480".parse().unwrap() };
        let kept = KeptTokens { file: Some(file.clone()), max_age: Some(Duration::from_secs(3600)) };
        let first = Tokens::kept_in(&file, kept.max_age).unwrap();
        let clock = Clock::start();
        let access = Access::new(TokensInForce::new(Some(first.clone())), origin, clock);
        let links = IssuedLinks::new(origin, None, kept, Some(published.clone()), clock.now());
        links.publish(Some(first.clone())).unwrap();
        let later = |seconds| clock.now().plus(Duration::from_secs(seconds));
        let is_due = |at| links.due().is_some_and(|due| due <= at);
        assert!(!is_due(later(3500)) && is_due(later(3600)));
        links.renew(&access, &[]).unwrap();
        let now = Tokens::read(&file).unwrap();
        assert!(now != first && links_file::read(&published).unwrap().tokens == now);
        assert_eq!(access.bearer_role(&format!("Bearer {}", now.watch)), Some(Role::Watch));
        assert_eq!(access.bearer_role(&format!("Bearer {}", first.control)), None);
        assert_eq!(links.body(&access).control, format!("http://127.0.0.1:8480/#token={}", now.control));
        assert!(!is_due(later(3500)));
        // Tokens that cannot be kept are not in force, and the attempt is repeated later.
        std::fs::remove_file(&file).unwrap();
        std::fs::create_dir(&file).unwrap();
        let error = links.renew(&access, &[]).unwrap_err();
        assert!(format!("{error:#}").contains("cannot be kept in"), "{error:#}");
        assert!(access.tokens().unwrap() == now && is_due(later(601)) && !is_due(later(599)));
        drop(links);
        assert!(!published.exists());
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
