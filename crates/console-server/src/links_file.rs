//! The address and the tokens of a served console in a file, for `barrelman links`: who may read the file may
//! control.
//!
//! The file belongs to its owner alone and is locked while the console is served. A file that is not locked
//! was left by a program that was killed.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail};
use barrelman_host::input;
use barrelman_host::output::{OutputFile, is_being_written};
use serde::{Deserialize, Serialize};

use super::origin::Origin;
use super::tokens::Tokens;

/// A served console, as its file states it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ServedConsole {
    /// Where the server listens.
    pub(super) origin: Origin,
    /// The tokens.
    pub(super) tokens: Tokens,
    /// SHA-256 of the console's own certificate authority.
    pub(super) fingerprint: Option<String>,
}

/// The file. Dropping it removes it.
pub(super) struct LinksFile {
    path: PathBuf,
    /// Holds the lock.
    _file: OutputFile,
}

impl LinksFile {
    /// Writes the file, in place of one that a killed program has left.
    pub(super) fn write(path: &Path, console: &ServedConsole) -> Result<Self> {
        let context = || format!("the console's links cannot be written to {}", path.display());
        let text = serde_json::to_string(console).with_context(context)?;
        let mut file = OutputFile::open(path, true).with_context(context)?;
        file.write_all(text.as_bytes()).with_context(context)?;
        Ok(Self { path: path.to_owned(), _file: file })
    }
}

impl Drop for LinksFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// Reads the file of a console that is served now.
pub(super) fn read(path: &Path) -> Result<ServedConsole> {
    let shown = path.display();
    let is_readable = rustix::fs::access(path, rustix::fs::Access::READ_OK).is_ok();
    match path.try_exists() {
        Ok(true) if is_readable => {}
        Ok(false) => bail!(
            "no console is served that writes its links to {shown}: start the service (`sudo systemctl start barrelman`), and look \
             why it ended with `journalctl -u barrelman`"
        ),
        Ok(true) | Err(_) => {
            bail!("{shown} may not be read by this user, for it holds the tokens: use `sudo barrelman links`")
        }
    }
    let bytes = input::read(path)?;
    if !is_being_written(path) {
        bail!(
            "{shown} was left by a program that was killed: start the service again (`sudo systemctl restart barrelman`)"
        );
    }
    serde_json::from_slice(&bytes).with_context(|| format!("{shown} is not a file of `run --links-file`"))
}

#[cfg(test)]
mod tests {
    use barrelman_host::input::is_readable_by_others;

    use super::super::origin::Scheme;
    use super::*;

    #[test]
    fn links_are_there_as_long_as_the_console_and_for_its_owner_alone() {
        let folder = std::env::temp_dir().join(format!("barrelman-links-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("links");
        let error = |path| format!("{:#}", read(path).err().unwrap());
        assert!(error(&path).contains("systemctl start barrelman"), "{}", error(&path));
        let tokens =
            Tokens { control: "control-0123456789".to_owned(), watch: "watch-0123456789".to_owned() };
        let origin = Origin { scheme: Scheme::Https, address: "0.0.0.0:8480".parse().unwrap() };
        let console = ServedConsole { origin, tokens, fingerprint: Some("AB:CD".to_owned()) };
        let file = LinksFile::write(&path, &console).unwrap();
        assert!(!is_readable_by_others(&path));
        let found = read(&path).unwrap();
        assert!(found.origin == console.origin && found.tokens == console.tokens);
        // What a killed program leaves is said to be old, and replaced by the next program.
        let content = std::fs::read(&path).unwrap();
        drop(file);
        assert!(!path.exists());
        std::fs::write(&path, content).unwrap();
        assert!(error(&path).contains("was killed"), "{}", error(&path));
        let file = LinksFile::write(&path, &console).unwrap();
        assert!(read(&path).is_ok());
        drop(file);
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
