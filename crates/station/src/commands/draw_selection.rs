//! The box that the operator draws around the boat in one frame of a stored video, in a browser.

use std::process::{Command, Stdio};

use anyhow::Result;
use barrelman_console_server::{AfterPicking, ConsoleSettings, pick};
use barrelman_video::VideoUrl;
use barrelman_vocab::PixelBox;

use super::stored_frame::stored_frame;

/// Whether the program runs in a graphical session, where a browser can be opened.
pub(super) fn has_display() -> bool {
    ["DISPLAY", "WAYLAND_DISPLAY"]
        .into_iter()
        .any(|name| std::env::var_os(name).is_some_and(|value| !value.is_empty()))
}

/// Serves the page with a frame until the box is drawn. The link is printed, and opened in the user's browser
/// where that is asked for and the link holds no token: every user of the computer can read the command line
/// of a program.
///
/// # Errors
/// If the video has no such frame, or the page cannot be served.
pub(super) fn draw_selection(
    url: &VideoUrl,
    frame: u64,
    settings: ConsoleSettings,
    after: AfterPicking,
    opens_browser: bool,
) -> Result<PixelBox> {
    let frame = stored_frame(url, frame)?;
    let opens_browser = opens_browser && may_open_browser(&settings);
    let selection = pick(settings, &frame.picture, after, |link| {
        tracing::info!("draw the box around the boat: {link}");
        if opens_browser {
            open_browser(link);
        }
    })?;
    let PixelBox { u, v, w, h } = selection;
    tracing::info!("selected; --select {u},{v},{w},{h} repeats this");
    Ok(selection)
}

/// Whether the page's link may be in the command line of a browser: it then holds no token.
fn may_open_browser(settings: &ConsoleSettings) -> bool {
    !settings.tokens.are_asked_for()
}

/// Opens the page in the user's browser, where the system knows one. Without one, the link is on the
/// terminal.
fn open_browser(link: &str) {
    let _ = Command::new("xdg-open")
        .arg(link)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
}

#[cfg(test)]
mod tests {
    use barrelman_console_server::{ConsoleAddress, KeptTokens};

    use super::*;

    #[test]
    fn a_link_with_a_token_is_in_no_command_line() {
        let listen = Some("127.0.0.1:0".parse().unwrap());
        let address = ConsoleAddress { listen, ..ConsoleAddress::default() };
        let with_tokens = ConsoleSettings::with_tokens(address.clone(), KeptTokens::default()).unwrap();
        assert!(!may_open_browser(&with_tokens));
        assert!(may_open_browser(
            &ConsoleSettings::without_tokens_on_loopback(address, KeptTokens::default()).unwrap()
        ));
    }
}
