//! Looks for a gimbal manager without moving anything: heartbeats and requests, no claim and no rate.

use barrelman_vocab::Timestamp;
use barrelman_vocab::mavlink::{Address, MavlinkPeers};

use super::camera_information::{CameraInformation, StreamInformation};
use super::command::{Command, Gimbal, Wanted};
use super::frame::FrameWriter;
use super::gimbal_choice::GimbalChoice;
use super::gimbal_reader::{GimbalReader, Holder, Information, Received};
use super::session_times::{ASK_SPACING, ASKS_FOR_INFORMATION, ATTITUDE_INTERVAL, MAX_CANDIDATES};
use super::signing::Signing;

/// What was found.
#[derive(Debug, Clone, Default)]
pub struct Findings {
    /// The components that were heard, without ground stations.
    pub components: Vec<Address>,
    /// The gimbals that managers describe, and which one is wanted.
    pub choice: GimbalChoice,
    /// The gimbal that is used.
    pub gimbal: Option<Gimbal>,
    /// What the gimbal manager says of its gimbal.
    pub information: Option<Information>,
    /// Who has the control.
    pub holder: Option<Holder>,
    /// Whether the gimbal's attitude is reported.
    pub has_attitude: bool,
    /// The cameras that say what they are.
    pub cameras: Vec<CameraInformation>,
    /// The video streams that cameras name.
    pub streams: Vec<StreamInformation>,
}

impl Findings {
    /// Whether nothing more is to be found.
    pub const fn is_complete(&self) -> bool {
        self.information.is_some() && self.holder.is_some() && self.has_attitude
    }
}

/// Looks for a gimbal manager.
#[derive(Debug, Clone)]
pub struct Probe {
    writer: FrameWriter,
    reader: GimbalReader,
    ask_at: Timestamp,
    asked: u32,
    findings: Findings,
}

impl Probe {
    /// A probe that has sent nothing yet.
    pub fn new(peers: MavlinkPeers, signing: Option<Signing>) -> Self {
        Self {
            writer: FrameWriter::new(peers.own, signing),
            reader: GimbalReader::new(peers, signing, Timestamp::ZERO),
            ask_at: Timestamp::ZERO,
            asked: 0,
            findings: Findings::default(),
        }
    }

    /// Appends the packets that are due now to `out`.
    pub fn poll(&mut self, now: Timestamp, out: &mut Vec<Vec<u8>>) {
        if now < self.ask_at {
            return;
        }
        self.ask_at = now.plus(ASK_SPACING);
        self.writer.set_time(now);
        self.writer.follow(self.reader.frames());
        let mut send = |command: Command| out.push(command.encode(&mut self.writer));
        send(Command::Heartbeat);
        for to in &self.findings.components {
            let to = *to;
            if !self.findings.cameras.iter().any(|camera| camera.camera == to) {
                send(Command::Request { to, message: Wanted::CameraInformation });
            }
            if !self.findings.streams.iter().any(|stream| stream.camera == to) {
                send(Command::Request { to, message: Wanted::StreamInformation });
            }
        }
        match self.findings.gimbal {
            None => {
                for to in &self.findings.components {
                    send(Command::Request { to: *to, message: Wanted::ManagerInformation });
                    if self.asked >= ASKS_FOR_INFORMATION {
                        send(Command::Request { to: *to, message: Wanted::ManagerStatus });
                    }
                }
                self.asked += u32::from(!self.findings.components.is_empty());
            }
            Some(gimbal) => {
                let to = gimbal.manager;
                if self.findings.information.is_none() {
                    send(Command::Request { to, message: Wanted::ManagerInformation });
                }
                send(Command::Request { to, message: Wanted::ManagerStatus });
                send(Command::SetInterval { to, message: Wanted::Attitude, interval: ATTITUDE_INTERVAL });
            }
        }
    }

    /// Takes received bytes.
    pub fn received(&mut self, bytes: &[u8]) {
        let findings = &mut self.findings;
        self.reader.read(bytes, |received| match received {
            Received::Heartbeat(from, false) => {
                let is_new = !findings.components.contains(&from);
                if is_new && findings.components.len() < MAX_CANDIDATES {
                    findings.components.push(from);
                }
            }
            Received::Gimbal(gimbal) => findings.gimbal = Some(gimbal),
            Received::Information(information) => findings.information = Some(information),
            Received::Holder(holder) => findings.holder = Some(holder),
            Received::Attitude(_) => findings.has_attitude = true,
            Received::Camera(camera) => {
                let is_new = findings.cameras.iter().all(|known| known.camera != camera.camera);
                if is_new && findings.cameras.len() < MAX_CANDIDATES {
                    findings.cameras.push(camera);
                }
            }
            Received::Stream(stream) => {
                let key = |stream: &StreamInformation| (stream.camera, stream.number);
                let is_new = findings.streams.iter().all(|known| key(known) != key(&stream));
                if is_new && findings.streams.len() < MAX_CANDIDATES {
                    findings.streams.push(stream);
                }
            }
            Received::Heartbeat(_, true)
            | Received::Device(_)
            | Received::ClaimAnswered(_)
            | Received::Restarted
            | Received::Other
            | Received::ZoomAnswered
            | Received::FieldOfView(_)
            | Received::Report(_)
            | Received::Autopilot(_) => {}
        });
    }

    /// What was found until now.
    pub fn findings(&self) -> Findings {
        Findings { choice: self.reader.choice().clone(), ..self.findings.clone() }
    }

    /// Whether nothing more is to be found.
    pub const fn is_complete(&self) -> bool {
        self.findings.is_complete()
    }
}
