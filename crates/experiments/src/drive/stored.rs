//! A drive on disk, JSON Lines: what it is made of, then each input with its tick, and the hash of all that happened.
//!
//! ```text
//! {"drive":"open","scenario_hash":"0c31...","seed":1,"size":[960,540],"tracker":"fused","tracker_behaviour":1,
//!  "law":{"name":"optimal","mode":"minimum-energy"},"law_behaviour":1,"coded":false,"program":"0.1.0"}
//! {"tick":0,"input":"engage"}
//! {"tick":431,"input":"helm","thrust":100,"rudder":0}
//! {"tick":3600,"hash":"8d5f..."}
//! ```
//! A file without its last line belongs to a program that was killed: it is run again as far as it goes.

use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use barrelman_trial::behaviour::{BehaviourVersions, FIRST};
use barrelman_vocab::PictureSize;
use serde::{Deserialize, Serialize};

use super::input::DriveInput;
use super::setup::DriveSetup;
use crate::law_choice::LawChoice;
use crate::tracker_choice::TrackerName;
use crate::world_url::WorldUrl;
use barrelman_host::input;
use barrelman_host::output::OutputFile;

/// The first line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Header {
    drive: String,
    scenario_hash: String,
    seed: u64,
    size: Option<(u32, u32)>,
    tracker: TrackerName,
    #[serde(default = "first_version")]
    tracker_behaviour: u32,
    /// Drives that do not say it were driven when the schema was the only law.
    #[serde(default = "schema")]
    law: LawChoice,
    #[serde(default = "first_version")]
    law_behaviour: u32,
    coded: bool,
    program: String,
}

const fn schema() -> LawChoice {
    LawChoice::SCHEMA
}

const fn first_version() -> u32 {
    FIRST
}

/// Every other line.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
enum Line {
    Input {
        tick: u64,
        #[serde(flatten)]
        input: DriveInput,
    },
    End {
        tick: u64,
        hash: String,
    },
}

/// Writes a drive down as it happens.
pub struct DriveWriter {
    path: PathBuf,
    file: BufWriter<OutputFile>,
}

impl DriveWriter {
    /// Begins a file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn begin(file: OutputFile, cast: &DriveSetup) -> Result<Self> {
        let mut writer = Self { path: file.path().to_owned(), file: BufWriter::new(file) };
        writer.line(&Header {
            drive: cast.url.scenario.clone(),
            scenario_hash: format!("{:016x}", cast.loaded.hash),
            seed: cast.url.seed,
            size: cast.url.size.map(|size| (size.width, size.height)),
            tracker: cast.tracker,
            tracker_behaviour: cast.tracker.behaviour_version(),
            law: cast.law,
            law_behaviour: cast.law.behaviour_version(),
            coded: cast.coded,
            program: env!("CARGO_PKG_VERSION").to_owned(),
        })?;
        Ok(writer)
    }

    /// An input, before a tick.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, tick: u64, input: DriveInput) -> Result<()> {
        self.line(&Line::Input { tick, input })
    }

    /// The end, before a tick.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn end(mut self, tick: u64, hash: String) -> Result<()> {
        self.line(&Line::End { tick, hash })
    }

    /// Inputs are few, and a program may be killed: each line goes out at once.
    fn line(&mut self, line: &impl Serialize) -> Result<()> {
        let text = serde_json::to_string(line)?;
        writeln!(self.file, "{text}")
            .and_then(|()| self.file.flush())
            .with_context(|| format!("{} cannot be written", self.path.display()))
    }
}

/// A drive that was written down.
#[derive(Debug)]
pub struct DriveReader {
    /// What it is made of.
    pub cast: DriveSetup,
    /// The behaviour versions of the tracker and the law of the drive.
    pub behaviour: BehaviourVersions,
    /// Its inputs, each with its tick.
    pub inputs: Vec<(u64, DriveInput)>,
    /// Its last tick, and the hash of all that happened; absent where the file is cut.
    pub end: Option<(u64, String)>,
}

impl DriveReader {
    /// Its last tick; of a file that is cut, that of the last input.
    pub fn last_tick(&self) -> u64 {
        let input = self.inputs.last().map_or(0, |(tick, _)| *tick);
        self.end.as_ref().map_or(input, |(tick, _)| *tick)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// If it is no drive, or the scenario has changed since.
    pub fn read(path: &Path) -> Result<Self> {
        let text = String::from_utf8(input::read(path)?);
        let read = text.context("it is no text").and_then(|text| Self::parse(&text));
        read.with_context(|| format!("{} cannot be driven again", path.display()))
    }

    fn parse(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        let header: Header = serde_json::from_str(first).context("its first line is no drive's")?;
        let behaviour = BehaviourVersions { tracker: header.tracker_behaviour, law: header.law_behaviour };
        let size = header.size.map(|(width, height)| PictureSize::new(width, height));
        let url = WorldUrl { scenario: header.drive, seed: header.seed, size };
        let cast = DriveSetup::new(url, header.tracker, header.law.validated("law.")?, header.coded)?;
        if format!("{:016x}", cast.loaded.hash) != header.scenario_hash {
            bail!("the scenario {} is another than it was then", cast.url.scenario);
        }
        let (mut inputs, mut end) = (Vec::new(), None);
        for (number, line) in lines.enumerate() {
            let line = serde_json::from_str(line).with_context(|| format!("line {}", number + 2))?;
            let last: u64 = inputs.last().map_or(0, |(tick, _)| *tick);
            match line {
                Line::Input { tick, input } if tick >= last && end.is_none() => inputs.push((tick, input)),
                Line::End { tick, hash } if tick >= last && end.is_none() => end = Some((tick, hash)),
                Line::Input { .. } | Line::End { .. } => bail!("line {} is out of order", number + 2),
            }
        }
        Ok(Self { cast, behaviour, inputs, end })
    }
}
