//! Logins that stay off the command line: in a file, or in an environment variable that the configuration names.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};

use barrelman_host::input;
use barrelman_video::url::{Login, VideoSource};

use crate::source_url::SourceUrl;

/// Permission bits that let the file's group or everybody read the file.
const READABLE_BY_OTHERS: u32 = 0o044;

/// Where a login is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LoginSource {
    /// `user:password` on the first line of this file.
    File(PathBuf),
    /// `user:password` in the environment variable of this name.
    Environment(String),
}

impl LoginSource {
    /// Reads the login. If others may read the file, a warning is logged.
    ///
    /// # Errors
    /// If the file or the variable does not exist, or holds no login. The message repeats nothing of the content.
    pub fn read(&self) -> Result<Login> {
        match self {
            Self::File(path) => read_file(path),
            Self::Environment(name) => {
                let text = std::env::var(name).map_err(|_| {
                    anyhow!(
                        "video.login_env names the environment variable {name}, which is not set or is not UTF-8: \
                         set it to user:password"
                    )
                })?;
                Login::parse(&text).with_context(|| format!("the environment variable {name} is not usable"))
            }
        }
    }
}

/// Parses the address of a video source and adds the login. The login is read only for a camera at `rtsp://`; other
/// sources take none.
///
/// # Errors
/// If the address cannot be parsed, or the login cannot be read.
pub fn source_url(address: &str, login: Option<&LoginSource>) -> Result<SourceUrl> {
    Ok(match (SourceUrl::parse(address)?, login) {
        (SourceUrl::Video(url), Some(login)) if matches!(url.source, VideoSource::Rtsp { .. }) => {
            SourceUrl::Video(url.with_login(login.read()?)?)
        }
        (url, _) => url,
    })
}

fn read_file(path: &Path) -> Result<Login> {
    if is_readable_by_others(path) {
        tracing::warn!(
            "the login file {} can be read by others: run `chmod 600 {}`",
            path.display(),
            path.display()
        );
    }
    let unusable = || format!("the login file {} is not usable", path.display());
    let text = String::from_utf8(input::read(path)?)
        .map_err(|_| anyhow!("it is not UTF-8 text"))
        .with_context(unusable)?;
    Login::parse(text.lines().next().unwrap_or_default()).with_context(unusable)
}

/// Whether the group or everybody may read a file; `false` for a file that does not exist.
pub fn is_readable_by_others(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|found| found.permissions().mode() & READABLE_BY_OTHERS != 0)
}
