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
    /// Of links that were renewed: why they end with the program, and what to do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) warning: Option<String>,
}

/// Where a console is, and where its tokens are kept.
pub(super) struct IssuedLinks {
    origin: Origin,
    /// SHA-256 of the console's own certificate authority.
    fingerprint: Option<String>,
    kept: KeptTokens,
    /// Where `barrelman links` finds them.
    links_file: Option<PathBuf>,
    /// The file of the links, while the console is served. Who writes tokens into files holds the lock.
    published: Mutex<Option<LinksFile>>,
    /// When the tokens are too old; `None`: never.
    renew_at: Mutex<Option<Timestamp>>,
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
        let (published, renew_at) = (Mutex::default(), Mutex::new(renew_at));
        Self { origin, fingerprint, kept, links_file, published, renew_at }
    }

    /// Writes the links for `barrelman links`, where they are wanted, in place of earlier ones.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub(super) fn publish(&self, tokens: Option<Tokens>) -> Result<()> {
        tokens.map_or(Ok(()), |tokens| self.publish_in(&mut locked(&self.published), tokens))
    }

    fn publish_in(&self, published: &mut Option<LinksFile>, tokens: Tokens) -> Result<()> {
        let Some(path) = &self.links_file else { return Ok(()) };
        let console = ServedConsole { origin: self.origin, tokens, fingerprint: self.fingerprint.clone() };
        // The file of the earlier links holds the lock of the file.
        *published = None;
        *published = Some(LinksFile::write(path, &console)?);
        Ok(())
    }

    /// Replaces the tokens at once: links that became known end, whatever the disk does. Of the cookies,
    /// those of `pages` stay. [`Self::keep`] writes the new tokens.
    ///
    /// # Errors
    /// If there are no random numbers: then the old tokens stay.
    pub(super) fn renew(&self, access: &Access, pages: &[Pass]) -> Result<()> {
        let tokens = Tokens::random().context("no random numbers for the console's tokens")?;
        access.renew(tokens, pages);
        let now = access.clock().now();
        *locked(&self.renew_at) = self.kept.max_age.map(|max_age| now.plus(max_age));
        Ok(())
    }

    /// Writes the tokens in force into their files.
    ///
    /// # Errors
    /// If a file cannot be written, with what follows from that. The other one is written all the same.
    pub(super) fn keep(&self, access: &Access) -> Result<()> {
        let mut published = locked(&self.published);
        let Some(tokens) = access.tokens() else { return Ok(()) };
        let kept = self.kept.file.as_deref().map_or(Ok(()), |file| tokens.keep_in(file));
        let published = self.publish_in(&mut published, tokens);
        kept.context("the old links hold again after a restart")
            .and(published.context("`barrelman links` does not show them"))
    }

    /// Replaces the tokens because of their age, in their file first: nobody would know new ones that are in
    /// no file. Of the cookies, those of `pages` stay.
    ///
    /// # Errors
    /// If there are no random numbers, or the tokens cannot be kept: then the old ones stay. If the links
    /// cannot be published: then the new ones hold.
    pub(super) fn renew_by_age(&self, access: &Access, pages: impl FnOnce() -> Vec<Pass>) -> Result<()> {
        let mut published = locked(&self.published);
        let now = access.clock().now();
        *locked(&self.renew_at) = self.kept.max_age.map(|_| now.plus(RETRY));
        let Some(old) = access.tokens() else { return Ok(()) };
        let tokens = Tokens::random().context("no random numbers for the console's tokens")?;
        if let Some(file) = &self.kept.file {
            tokens.keep_in(file)?;
        }
        if !access.renew_by_age(&old, tokens.clone(), &pages()) {
            // Who asked for new links meanwhile waits to write them.
            return Ok(());
        }
        *locked(&self.renew_at) = self.kept.max_age.map(|max_age| now.plus(max_age));
        self.publish_in(&mut published, tokens).context("the console's tokens were renewed")
    }

    /// When the tokens are too old; `None`: never.
    pub(super) fn due(&self) -> Option<Timestamp> {
        *locked(&self.renew_at)
    }

    /// The links in force.
    pub(super) fn body(&self, access: &Access) -> LinksBody {
        let tokens = access.tokens();
        let (control, watch) = tokens.map(|tokens| (tokens.control, tokens.watch)).unzip();
        LinksBody {
            control: link_to_page(self.origin, control.as_deref()),
            watch: link_to_page(self.origin, watch.as_deref()),
            warning: None,
        }
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use barrelman_host::clock::Clock;

    use super::super::access::Role;
    use super::super::links_file;
    use super::super::origin::Scheme;
    use super::super::tokens::TokensInForce;
    use super::*;

    struct Scene {
        folder: PathBuf,
        /// The file of the tokens.
        file: PathBuf,
        /// The file of the links.
        published: PathBuf,
        first: Tokens,
        access: Access,
        links: IssuedLinks,
    }

    impl Scene {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("barrelman-{name}-{}", std::process::id()));
            std::fs::create_dir_all(&folder).unwrap();
            let (file, published) = (folder.join("tokens"), folder.join("links"));
            let origin = Origin { scheme: Scheme::Http, address: "127.0.0.1:8480".parse().unwrap() };
            let kept = KeptTokens { file: Some(file.clone()), max_age: Some(Duration::from_secs(3600)) };
            let first = Tokens::kept_in(&file, kept.max_age).unwrap();
            let clock = Clock::start();
            let access = Access::new(TokensInForce::new(Some(first.clone())), origin, clock);
            let links = IssuedLinks::new(origin, None, kept, Some(published.clone()), clock.now());
            links.publish(Some(first.clone())).unwrap();
            Self { folder, file, published, first, access, links }
        }

        fn is_due_in(&self, seconds: u64) -> bool {
            let at = self.access.clock().now().plus(Duration::from_secs(seconds));
            self.links.due().is_some_and(|due| due <= at)
        }

        /// The file of the tokens cannot be written any more.
        fn spoil_file(&self) {
            std::fs::remove_file(&self.file).unwrap();
            std::fs::create_dir(&self.file).unwrap();
        }
    }

    impl Drop for Scene {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.folder);
        }
    }

    #[test]
    fn tokens_that_are_renewed_by_age_are_in_their_file_in_the_links_and_in_force() {
        let scene = Scene::new("links-by-age");
        let Scene { first, access, links, .. } = &scene;
        assert!(!scene.is_due_in(3500) && scene.is_due_in(3600));
        links.renew_by_age(access, Vec::new).unwrap();
        let now = Tokens::read(&scene.file).unwrap();
        assert!(now != *first && links_file::read(&scene.published).unwrap().tokens == now);
        assert_eq!(access.bearer_role(&format!("Bearer {}", now.watch)), Some(Role::Watch));
        assert_eq!(access.bearer_role(&format!("Bearer {}", first.control)), None);
        assert_eq!(links.body(access).control, format!("http://127.0.0.1:8480/#token={}", now.control));
        assert!(!scene.is_due_in(3500));
        // Tokens that cannot be kept are not in force, and the attempt is repeated later.
        scene.spoil_file();
        let error = links.renew_by_age(access, Vec::new).unwrap_err();
        assert!(format!("{error:#}").contains("cannot be kept in"), "{error:#}");
        assert!(access.tokens().unwrap() == now && scene.is_due_in(601) && !scene.is_due_in(599));
        *locked(&links.published) = None;
        assert!(!scene.published.exists());
    }

    #[test]
    fn new_links_hold_before_any_file_is_written_and_whether_or_not_it_is() {
        let scene = Scene::new("links-by-hand");
        let Scene { first, access, links, .. } = &scene;
        links.renew(access, &[]).unwrap();
        let second = access.tokens().unwrap();
        assert!(second != *first && Tokens::read(&scene.file).unwrap() == *first);
        links.keep(access).unwrap();
        assert!(Tokens::read(&scene.file).unwrap() == second);
        assert!(links_file::read(&scene.published).unwrap().tokens == second);
        scene.spoil_file();
        links.renew(access, &[]).unwrap();
        assert!(links.keep(access).is_err() && access.tokens().unwrap() != second);
        let published = links_file::read(&scene.published).unwrap().tokens;
        assert!(published == access.tokens().unwrap(), "the file that can be written is");
    }
}
