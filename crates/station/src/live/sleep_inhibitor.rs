//! Keeps the machine awake during a run with a vehicle: `systemd-inhibit` as a child process.
//!
//! The child holds the inhibitor as long as its standard input is open, and so no longer than this program
//! lives.

use std::io;
use std::os::unix::process::CommandExt as _;
use std::process::{ChildStdin, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::supervision::SOCKET;

const PROGRAM: &str = "systemd-inhibit";
const WHAT: &str = "--what=sleep:idle:handle-lid-switch";

/// Whether the machine can be kept awake.
pub fn is_possible() -> bool {
    let tried = Command::new(PROGRAM)
        .args([WHAT, "--mode=block", "true"])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    tried.is_ok_and(|status| status.success())
}

/// A held inhibitor. Dropping it lets the machine sleep again.
#[derive(Debug)]
pub(super) struct SleepInhibitor {
    is_released: Arc<AtomicBool>,
    /// Its end ends the child.
    _input: Option<ChildStdin>,
}

impl SleepInhibitor {
    /// Takes the inhibitor. Without one a warning says what that means.
    pub(super) fn hold() -> Option<Self> {
        Self::start().map_err(|error| warn(&error.to_string())).ok()
    }

    fn start() -> io::Result<Self> {
        let mut child = Command::new(PROGRAM)
            .args([WHAT, "--mode=block", "--who=barrelman"])
            .args(["--why=moves the camera of a vehicle", "cat"])
            // It would tell the service manager that the program is ready.
            .env_remove(SOCKET)
            // Ctrl-C on the terminal is for this program alone.
            .process_group(0)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?;
        let input = child.stdin.take();
        let is_released = Arc::new(AtomicBool::new(false));
        let released = Arc::clone(&is_released);
        std::thread::Builder::new().name("inhibitor".to_owned()).spawn(move || {
            let status = child.wait();
            if !released.load(Ordering::Relaxed) {
                warn(&status.map_or_else(|error| error.to_string(), |status| status.to_string()));
            }
        })?;
        Ok(Self { is_released, _input: input })
    }
}

impl Drop for SleepInhibitor {
    fn drop(&mut self) {
        self.is_released.store(true, Ordering::Relaxed);
    }
}

fn warn(reason: &str) {
    tracing::warn!(
        "{PROGRAM} does not keep this machine awake ({reason}): while it sleeps, nothing stops the camera; switch \
         sleeping off"
    );
}
