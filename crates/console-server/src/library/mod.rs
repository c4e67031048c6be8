//! The recordings of a folder, for the page `/library`: list, film, tables, rename, delete.
//!
//! No name that a page sends leads out of the folder ([`RecordingName`]). A film is made by this program in a
//! process of its own at the lowest priority, beside the recording: `NAME.export`.
//!
//! What must not be here: anything that a run waits for.

mod name;
mod part;
mod thumbnail;
mod turns;

pub(super) mod routes;

pub(crate) use routes::NewName;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use barrelman_host::output::is_being_written;
use barrelman_trial::records::{IndexedRecording, read_sortie};
use barrelman_trial::sortie::Sortie;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use name::RecordingName;
use part::{Form, MayEncode, Part, part_of};
use thumbnail::thumbnail_of;
use turns::{LEAST_PRIORITY, Turns};

/// The file of an export that is written last, and gets this name when it is whole.
const FILM: &str = "annotated.mp4";
/// The files of an export that a page may get.
const EXPORTED: [&str; 4] = [FILM, "report.html", "video.mp4", "trial.csv"];

/// Recordings that are read at the same time.
const READERS: usize = 2;

/// The recordings of a folder.
#[derive(Debug)]
pub struct Library {
    folder: PathBuf,
    /// The program, which exports.
    program: PathBuf,
    exports: Mutex<BTreeMap<RecordingName, Child>>,
    observed: Mutex<Observed>,
    /// To read recordings.
    reading: Turns,
    /// To sum up recordings, which can take minutes: nobody who only reads waits for it.
    observing: Turns,
}

/// The summaries of recordings that hold none, by name and size.
type Observed = BTreeMap<(RecordingName, u64), Result<Sortie, String>>;

/// A recording, as the page lists it.
#[derive(Debug, Serialize, JsonSchema)]
#[schemars(rename = "Recording")]
pub(crate) struct Listed {
    name: RecordingName,
    bytes: u64,
    state: RecordingState,
    film: FilmState,
    /// Which files of the film there are.
    exported: Vec<&'static str>,
    /// The summary; absent while it is recorded, and where the program was killed.
    sortie: Option<Sortie>,
}

/// How far a recording is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum RecordingState {
    /// A program writes it now.
    BeingRecorded,
    /// It was ended in order.
    Complete,
    /// It was cut off, holds no summary, or cannot be read.
    CutOff,
}

/// Whether a recording has a film.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum FilmState {
    /// Nobody asked for one.
    None,
    /// It is being made.
    BeingMade,
    /// It is there.
    Ready,
    /// It could not be made.
    Failed,
}

impl Library {
    /// The recordings of `folder`, which `program` exports.
    pub fn new(folder: PathBuf, program: PathBuf) -> Self {
        let (reading, observing) = (Turns::new(READERS), Turns::new(1));
        Self { folder, program, exports: Mutex::default(), observed: Mutex::default(), reading, observing }
    }

    /// The recordings, the newest first. A folder that does not exist holds none.
    fn list(&self) -> io::Result<Vec<Listed>> {
        let entries = match std::fs::read_dir(&self.folder) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            entries => entries?,
        };
        let mut found = Vec::new();
        for entry in entries {
            let entry = entry?;
            let Some(name) = entry.file_name().to_str().and_then(|name| name.parse().ok()) else { continue };
            if let Some(listed) = self.listed(name, &entry.path()) {
                found.push((entry.metadata()?.modified()?, listed));
            }
        }
        found.sort_by(|(one, listed), (other, others)| (other, &others.name).cmp(&(one, &listed.name)));
        Ok(found.into_iter().map(|(_, listed)| listed).collect())
    }

    /// `None`: no file. One that cannot be read is listed: its summary is why not.
    fn listed(&self, name: RecordingName, path: &Path) -> Option<Listed> {
        let metadata = path.symlink_metadata().ok().filter(std::fs::Metadata::is_file)?;
        let (state, sortie) = if is_being_written(path) {
            (RecordingState::BeingRecorded, None)
        } else {
            let sortie = File::open(path).and_then(read_sortie).unwrap_or_default();
            let state = if sortie.is_some() { RecordingState::Complete } else { RecordingState::CutOff };
            (state, sortie)
        };
        let film = self.film_state(&name);
        let exported = match film {
            FilmState::Ready => {
                EXPORTED.into_iter().filter(|file| self.file(&name, file).is_some()).collect()
            }
            FilmState::None | FilmState::BeingMade | FilmState::Failed => Vec::new(),
        };
        Some(Listed { name, bytes: metadata.len(), state, film, exported, sortie })
    }

    /// The summary of a recording that was cut off, or why there is none. The program reads it as a whole in a
    /// process of its own, one recording at a time.
    ///
    /// # Errors
    /// If there is no such recording, or the program cannot be started.
    fn observed_sortie(&self, name: &RecordingName) -> io::Result<Result<Sortie, String>> {
        let path = self.path(name);
        let metadata = path.symlink_metadata()?;
        let mut observed = self.observed.lock().unwrap_or_else(PoisonError::into_inner);
        let key = (name.clone(), metadata.len());
        if !observed.contains_key(&key) {
            let sortie = self.observe(&path)?;
            observed.retain(|(other, _), _| other != name);
            observed.insert(key.clone(), sortie);
        }
        Ok(observed[&key].clone())
    }

    /// The summary that a recording holds; `None`: it was cut off.
    ///
    /// # Errors
    /// If there is no such recording, it is being written, or it cannot be read.
    fn stored_sortie(&self, name: &RecordingName) -> io::Result<Option<Sortie>> {
        let path = self.path(name);
        if !path.symlink_metadata()?.is_file() {
            return Err(io::Error::new(io::ErrorKind::NotFound, "it is no file"));
        }
        self.require_finished(name)?;
        read_sortie(File::open(&path)?)
    }

    /// The summary of a recording from all that it holds, or why there is none.
    fn observe(&self, path: &Path) -> io::Result<Result<Sortie, String>> {
        let mut command = Command::new(&self.program);
        command.args(["library", "--json"]).arg(path).stdin(Stdio::null());
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn()?;
        give_way(&child);
        let output = child.wait_with_output()?;
        if !output.status.success() {
            let text = String::from_utf8_lossy(&output.stderr).trim().to_owned();
            // A page learns no place on the machine.
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let text = text.trim_start_matches("ERROR ").replace(&*path.to_string_lossy(), &name);
            return Ok(Err(if text.is_empty() { "it cannot be read".to_owned() } else { text }));
        }
        let observed = serde_json::from_slice::<WithSortie>(&output.stdout);
        Ok(observed.map(|observed| observed.sortie).map_err(|error| error.to_string()))
    }

    fn film_state(&self, name: &RecordingName) -> FilmState {
        let mut exports = self.exports.lock().unwrap_or_else(PoisonError::into_inner);
        let is_running = exports.get_mut(name).map(is_running);
        let is_there = self.export_folder(name).join(FILM).is_file();
        match (is_running, is_there) {
            (Some(true), _) => FilmState::BeingMade,
            (_, true) => FilmState::Ready,
            (Some(false), false) => FilmState::Failed,
            (None, false) => FilmState::None,
        }
    }

    /// Begins to make the film of a recording, and its tables. A film that is made or being made stays. The
    /// export names the film when it is whole, so a film that is there is complete.
    ///
    /// # Errors
    /// If the film of another recording is being made, or the program cannot be started.
    fn make_film(&self, name: &RecordingName) -> io::Result<()> {
        if matches!(self.film_state(name), FilmState::BeingMade | FilmState::Ready) {
            return Ok(());
        }
        let mut exports = self.exports.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(other) = running(&mut exports) {
            let text = format!("the film of {} is being made: wait until it is ready", other.as_str());
            return Err(io::Error::new(io::ErrorKind::ResourceBusy, text));
        }
        let export = Command::new(&self.program)
            .args(["export", "--annotated", "--report", "--force", "--output"])
            .arg(self.export_folder(name))
            .arg(self.path(name))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?;
        give_way(&export);
        exports.insert(name.clone(), export);
        Ok(())
    }

    fn rename(&self, from: &RecordingName, to: &RecordingName) -> io::Result<()> {
        self.require_finished(from)?;
        if self.path(to).exists() || self.export_folder(to).exists() {
            return Err(io::Error::new(io::ErrorKind::AlreadyExists, "there is a recording of this name"));
        }
        std::fs::rename(self.path(from), self.path(to))?;
        if self.export_folder(from).is_dir() {
            std::fs::rename(self.export_folder(from), self.export_folder(to))?;
        }
        Ok(())
    }

    fn delete(&self, name: &RecordingName) -> io::Result<()> {
        self.require_finished(name)?;
        std::fs::remove_file(self.path(name))?;
        if self.export_folder(name).is_dir() {
            std::fs::remove_dir_all(self.export_folder(name))?;
        }
        Ok(())
    }

    fn require_finished(&self, name: &RecordingName) -> io::Result<()> {
        let is_busy = is_being_written(&self.path(name)) || self.film_state(name) == FilmState::BeingMade;
        if is_busy {
            return Err(io::Error::new(io::ErrorKind::ResourceBusy, "it is being written"));
        }
        Ok(())
    }

    /// The file of a recording that a page asks for: the recording itself, or a file of its export.
    fn file(&self, name: &RecordingName, file: &str) -> Option<PathBuf> {
        let path = match file {
            "recording.mcap" => self.path(name),
            _ => self.export_folder(name).join(EXPORTED.iter().find(|known| **known == file)?),
        };
        path.symlink_metadata().is_ok_and(|metadata| metadata.is_file()).then_some(path)
    }

    /// The part of a recording that shows the moment `from` after its first step. `None`: a recording
    /// that is being written, or was cut off, has no index.
    fn part(
        &self,
        name: &RecordingName,
        from: Duration,
        form: Form,
        may_encode: MayEncode<'_>,
    ) -> anyhow::Result<Option<Part>> {
        let path = self.path(name);
        let Some(mut recording) = IndexedRecording::open(BufReader::new(File::open(&path)?))? else {
            return Ok(None);
        };
        part_of(&mut recording, from, form, may_encode).map(Some)
    }

    /// A picture of a recording; `None`: one that is being written or was cut off, or has no picture.
    fn thumbnail(&self, name: &RecordingName) -> anyhow::Result<Option<Vec<u8>>> {
        match IndexedRecording::open(BufReader::new(File::open(self.path(name))?))? {
            Some(mut recording) => thumbnail_of(&mut recording),
            None => Ok(None),
        }
    }

    fn path(&self, name: &RecordingName) -> PathBuf {
        self.folder.join(name.as_str())
    }

    fn export_folder(&self, name: &RecordingName) -> PathBuf {
        self.folder.join(format!("{}.export", name.stem()))
    }
}

impl Drop for Library {
    /// Ends the exports: they must not outlive the program.
    fn drop(&mut self) {
        let exports = self.exports.get_mut().unwrap_or_else(PoisonError::into_inner);
        for export in exports.values_mut() {
            let _ = export.kill();
            let _ = export.wait();
        }
    }
}

/// The recording whose film is being made.
fn running(exports: &mut BTreeMap<RecordingName, Child>) -> Option<RecordingName> {
    let mut running = exports.iter_mut().filter_map(|(name, export)| is_running(export).then_some(name));
    running.next().cloned()
}

fn is_running(export: &mut Child) -> bool {
    matches!(export.try_wait(), Ok(None))
}

/// What `library --json` says of a recording.
#[derive(Deserialize)]
struct WithSortie {
    sortie: Sortie,
}

/// Lets a run come before a process. Where the system refuses this, the process is only not as gentle.
fn give_way(process: &Child) {
    let id = i32::try_from(process.id()).ok().and_then(rustix::process::Pid::from_raw);
    let _ = rustix::process::setpriority_process(id, LEAST_PRIORITY);
}

#[cfg(test)]
mod tests;
