//! What a sortie was like, in words.

use std::fmt;
use std::io::{Write as _, stdout};
use std::path::Path;
use std::sync::mpsc::channel;
use std::time::Duration;

use barrelman_trial::sortie::{Happening, Moment, Sortie, length};
use barrelman_vocab::{Named as _, StopCause};
use jiff::tz::TimeZone;
use jiff::{Timestamp, Zoned};

/// The text of a sortie: a few lines.
pub struct SortieText<'a> {
    /// The sortie.
    pub sortie: &'a Sortie,
    /// Its recording.
    pub path: &'a Path,
    /// Whether the recording was cut off.
    pub is_cut: bool,
}

/// How long a run waits at its end for an output that nobody reads.
const PRINT_TIMEOUT: Duration = Duration::from_millis(500);

impl SortieText<'_> {
    /// Prints the text. An output that is closed, or that nobody reads, does not keep a run from its end.
    pub fn print(&self) {
        let text = self.to_string();
        let (printed, is_printed) = channel();
        let printing = std::thread::Builder::new().name("sortie".to_owned()).spawn(move || {
            let _ = stdout().write_all(text.as_bytes());
            let _ = printed.send(());
        });
        if printing.is_ok() {
            let _ = is_printed.recv_timeout(PRINT_TIMEOUT);
        }
    }
}

impl fmt::Display for SortieText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sortie, path, is_cut } = *self;
        let cut = if is_cut { "; cut off: the program was killed" } else { "" };
        let lasted = length(sortie.length_s);
        writeln!(f, "recording: {}", path.display())?;
        match (local_time(sortie, 0.0), local_time(sortie, sortie.length_s)) {
            (Some(began), Some(ended)) => {
                let (began, ended) = (began.strftime("%e %b %Y, %H:%M:%S"), ended.strftime("%H:%M:%S %Z"));
                writeln!(f, "  {began} to {ended}, {lasted}{cut}")?;
            }
            _ => writeln!(f, "  {lasted} of simulated time{cut}")?,
        }
        for line in sortie.lines() {
            writeln!(f, "  {line}")?;
        }
        writeln!(f, "  see it: barrelman report {} --output sortie.html", quoted(path))?;
        writeln!(f, "  film:   barrelman export {} --output sortie --annotated", quoted(path))
    }
}

/// A sortie in one line of a list.
pub struct SortieLine<'a> {
    /// The sortie.
    pub sortie: &'a Sortie,
    /// Its recording.
    pub path: &'a Path,
    /// Size of the recording.
    pub bytes: u64,
    /// Whether the recording was cut off.
    pub is_cut: bool,
}

impl fmt::Display for SortieLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { sortie, path, bytes, is_cut } = *self;
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let stop = sortie.moments.iter().rev().find_map(|moment| match &moment.what {
            Happening::Stopped { cause: StopCause::Ending } => Some("ended"),
            Happening::Stopped { cause } => Some(cause.text()),
            _ => None,
        });
        write!(
            f,
            "{}  {:>12}  {:>8.1} MB  {name}  {}  {}",
            local_time(sortie, 0.0).map_or_else(
                || "simulated time   ".to_owned(),
                |began| began.strftime("%e %b %Y %H:%M").to_string()
            ),
            length(sortie.length_s),
            bytes as f64 / 1e6,
            sortie.video,
            if is_cut { "cut off" } else { stop.unwrap_or("ended") }
        )
    }
}

/// The moments of a sortie, one a line, with the time of day.
pub struct MomentLines<'a>(pub &'a Sortie);

impl fmt::Display for MomentLines<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for Moment { at_s, what } in &self.0.moments {
            let at = local_time(self.0, *at_s).map(|at| format!("{}  ", at.strftime("%H:%M:%S")));
            writeln!(f, "  {}{at_s:>8.1} s  {}", at.unwrap_or_default(), what.text())?;
        }
        Ok(())
    }
}

/// The time of day at a time since the beginning; `None`: the recording is one of simulated time alone.
fn local_time(sortie: &Sortie, at_s: f64) -> Option<Zoned> {
    /// No recording is older than the program. A clock of simulated time begins at 0.
    const EARLIEST_UNIX_NS: u64 = 1_000_000_000_000_000_000;
    if sortie.began_unix_ns < EARLIEST_UNIX_NS {
        return None;
    }
    let at_ns = i128::from(sortie.began_unix_ns) + (at_s * 1e9) as i128;
    Some(Timestamp::from_nanosecond(at_ns).ok()?.to_zoned(TimeZone::system()))
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = text.chars().all(|c| c.is_ascii_alphanumeric() || "/._-+=:@%,".contains(c));
    if is_plain { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}
