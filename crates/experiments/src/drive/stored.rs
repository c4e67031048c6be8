//! A drive as a file (JSON Lines): its setup, each request with its tick, and the hash of the drive.
//!
//! ```text
//! {"drive":"open","scenario_hash":"0c31...","seed":1,"size":[960,540],"tracker":"fused",
//!  "law":{"name":"optimal","mode":"minimum-energy"},"encoded":false,"program":"0.1.0+5c1f0a9be2d47f60"}
//! {"tick":0,"request":{"kind":"engage"}}
//! {"tick":431,"request":{"kind":"steer","throttle":1.0,"rudder":0.0}}
//! {"tick":3600,"hash":"8d5f..."}
//! ```
//! A file without its last line was cut off, for instance because the program was killed. It is run again up
//! to its last request.

use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use barrelman_sim::tick::TICKS_PER_SECOND;
use barrelman_vocab::{OperatorRequest, PictureSize};
use serde::{Deserialize, Serialize};

use super::setup::DriveSetup;
use crate::law_choice::{LawChoice, LawKeys};
use crate::tracker_choice::TrackerName;
use crate::world_url::WorldUrl;
use barrelman_host::input;
use barrelman_host::output::OutputFile;

/// Maximum duration of a stored drive, seconds: a day.
const MAX_DRIVE_S: f64 = 86_400.0;
/// The last tick that a drive can have.
const MAX_TICK: u64 = MAX_DRIVE_S as u64 * TICKS_PER_SECOND as u64;

/// The first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Header {
    drive: String,
    scenario_hash: String,
    seed: u64,
    size: Option<(u32, u32)>,
    tracker: TrackerName,
    law: LawChoice,
    encoded: bool,
    #[serde(default, skip_serializing_if = "core::ops::Not::not")]
    hands_on: bool,
    program: String,
}

/// Every other line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
enum Line {
    Request { tick: u64, request: OperatorRequest },
    End { tick: u64, hash: String },
}

/// Writes a drive to a file while the drive runs.
pub struct DriveWriter {
    path: PathBuf,
    file: BufWriter<OutputFile>,
}

impl DriveWriter {
    /// Writes the setup.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn begin(file: OutputFile, setup: &DriveSetup) -> Result<Self> {
        let mut writer = Self { path: file.path().to_owned(), file: BufWriter::new(file) };
        writer.write_line(&Header {
            drive: setup.url.scenario.clone(),
            scenario_hash: format!("{:016x}", setup.loaded.hash),
            seed: setup.url.seed,
            size: setup.url.size.map(|size| (size.width, size.height)),
            tracker: setup.tracker,
            law: setup.law,
            encoded: setup.encoded,
            hands_on: setup.hands_on,
            program: barrelman_host::program::identity().to_owned(),
        })?;
        Ok(writer)
    }

    /// Adds a request before a tick.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, tick: u64, request: OperatorRequest) -> Result<()> {
        self.write_line(&Line::Request { tick, request })
    }

    /// Writes the last tick and the hash of the drive.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(mut self, tick: u64, hash: String) -> Result<()> {
        self.write_line(&Line::End { tick, hash })
    }

    /// Writes a line at once: requests are few, and the program may be killed.
    fn write_line(&mut self, line: &impl Serialize) -> Result<()> {
        let text = serde_json::to_string(line)?;
        writeln!(self.file, "{text}")
            .and_then(|()| self.file.flush())
            .with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

/// A drive that was read from its file.
#[derive(Debug)]
pub struct StoredDrive {
    /// The setup.
    pub setup: DriveSetup,
    /// The program that stored the drive: version and hash of the executable.
    pub program: String,
    /// The requests, each with its tick.
    pub requests: Vec<(u64, OperatorRequest)>,
    /// The last tick and the hash of the drive; `None` if the file is cut off.
    pub end: Option<(u64, String)>,
}

impl StoredDrive {
    /// The last tick, or the tick of the last request if the file is cut off.
    pub fn last_tick(&self) -> u64 {
        let request = self.requests.last().map_or(0, |(tick, _)| *tick);
        self.end.as_ref().map_or(request, |(tick, _)| *tick)
    }

    /// Reads a drive from its file.
    ///
    /// # Errors
    /// The file is not a drive, or its scenario has changed since.
    pub fn read(path: &Path) -> Result<Self> {
        let text = String::from_utf8(input::read(path)?);
        let read = text.context("it is no text").and_then(|text| Self::parse(&text));
        read.with_context(|| format!("{} cannot be driven again", path.display()))
    }

    /// Reads a drive from the text of its file.
    ///
    /// # Errors
    /// The text is not a drive, or its scenario has changed since.
    pub fn parse(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        let header: Header = serde_json::from_str(first).context("its first line is no drive's")?;
        let size = header.size.map(|(width, height)| PictureSize::new(width, height));
        let url = WorldUrl { scenario: header.drive, seed: header.seed, size };
        let law = header.law.validated(LawKeys::FILE)?;
        let setup = DriveSetup::new(url, header.tracker, law, header.encoded)?;
        let setup = DriveSetup { hands_on: header.hands_on, ..setup };
        if format!("{:016x}", setup.loaded.hash) != header.scenario_hash {
            bail!("the scenario {} is another than it was then", setup.url.scenario);
        }
        let (mut requests, mut end) = (Vec::new(), None);
        for (number, line) in lines.enumerate() {
            let line = serde_json::from_str(line).with_context(|| format!("line {}", number + 2))?;
            let last: u64 = requests.last().map_or(0, |(tick, _)| *tick);
            let (Line::Request { tick, .. } | Line::End { tick, .. }) = &line;
            if *tick > MAX_TICK {
                bail!(
                    "line {}: tick {tick}: a drive has at most {MAX_TICK} ticks, which are {MAX_DRIVE_S} s",
                    number + 2
                );
            }
            match line {
                Line::Request { tick, request } if tick >= last && end.is_none() => {
                    requests.push((tick, request))
                }
                Line::End { tick, hash } if tick >= last && end.is_none() => end = Some((tick, hash)),
                Line::Request { .. } | Line::End { .. } => bail!("line {} is out of order", number + 2),
            }
        }
        Ok(Self { setup, program: header.program, requests, end })
    }
}
