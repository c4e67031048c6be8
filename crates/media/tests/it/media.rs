//! The program under test, started as `barrelman` starts it.

use std::os::fd::OwnedFd;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use barrelman_media_protocol::channel::{Channel, ChannelError};
use barrelman_media_protocol::decoder::{DecodedPicture, FromDecoder, ToDecoder};
use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::{BUILD, DecoderSettings, Role, Start};

use crate::clip::Unit;

/// Longest wait for a message. A machine that runs all tests at once is slow.
const PATIENCE: Duration = Duration::from_secs(60);

pub(crate) fn deadline() -> Instant {
    Instant::now() + PATIENCE
}

/// A running `barrelman-media`.
pub(crate) struct Media {
    pub channel: Channel,
    child: Child,
}

impl Media {
    pub(crate) fn start(role: Role) -> Self {
        Self::of_build(BUILD, role)
    }

    pub(crate) fn of_build(build: &str, role: Role) -> Self {
        let (mut channel, far) = Channel::pair().unwrap();
        let child = spawn(far);
        channel.send(&Start { build: build.to_owned(), role }, b"").unwrap();
        Self { channel, child }
    }

    pub(crate) fn decoder(format: CodedFormat, is_live: bool) -> Self {
        let mut media = Self::start(Role::Decoder(DecoderSettings { format, is_live }));
        let ready = media.decoder_message().unwrap().0;
        assert!(matches!(ready, FromDecoder::Ready { .. }), "{ready:?}");
        media
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// The next message of a decoder, with its payload.
    pub(crate) fn decoder_message(&mut self) -> Result<(FromDecoder, Vec<u8>), ChannelError> {
        self.receive().map(|received| received.expect("no message has come in time"))
    }

    pub(crate) fn receive<M: serde::de::DeserializeOwned>(
        &mut self,
    ) -> Result<Option<(M, Vec<u8>)>, ChannelError> {
        let Some((message, length)) = self.channel.receive(deadline())? else { return Ok(None) };
        let mut payload = vec![0; length];
        self.channel.read_payload(&mut payload)?;
        Ok(Some((message, payload)))
    }

    /// What comes up to the `Done` of a message to the decoder.
    pub(crate) fn answer(&mut self, message: ToDecoder, payload: &[u8]) -> Answer {
        self.channel.send(&message, payload).unwrap();
        let mut pictures = Vec::new();
        loop {
            match self.decoder_message().unwrap() {
                (FromDecoder::Picture(picture), samples) => pictures.push((picture, samples)),
                (FromDecoder::Done { damage }, _) => return Answer { pictures, damage },
                (other, _) => panic!("{other:?}"),
            }
        }
    }

    pub(crate) fn decode(&mut self, unit: &Unit) -> Answer {
        self.answer(ToDecoder::Decode { pts_ns: unit.pts_ns, key: unit.key }, &unit.payload)
    }

    /// All pictures of these units, with a flush at their end. No unit is damaged.
    pub(crate) fn decode_all(&mut self, units: &[Unit]) -> Vec<(DecodedPicture, Vec<u8>)> {
        let mut pictures = Vec::new();
        for unit in units {
            let answer = self.decode(unit);
            assert_eq!(answer.damage, None);
            pictures.extend(answer.pictures);
        }
        pictures.extend(self.answer(ToDecoder::Flush, b"").pictures);
        pictures
    }

    /// The same, whatever is damaged.
    pub(crate) fn decode_all_leniently(&mut self, units: &[Unit]) -> Vec<(DecodedPicture, Vec<u8>)> {
        let mut pictures: Vec<_> = units.iter().flat_map(|unit| self.decode(unit).pictures).collect();
        pictures.extend(self.answer(ToDecoder::Flush, b"").pictures);
        pictures
    }

    /// Closes the channel and waits for the end of the process.
    pub(crate) fn close(self) -> ExitStatus {
        let Self { channel, mut child } = self;
        drop(channel);
        wait(&mut child)
    }

    /// Waits for the end of the process.
    pub(crate) fn end(&mut self) -> ExitStatus {
        wait(&mut self.child)
    }
}

/// What a decoder answers to one message.
pub(crate) struct Answer {
    pub pictures: Vec<(DecodedPicture, Vec<u8>)>,
    pub damage: Option<String>,
}

fn spawn(far: OwnedFd) -> Child {
    Command::new(env!("CARGO_BIN_EXE_barrelman-media"))
        .stdin(Stdio::from(far))
        .stdout(Stdio::null())
        .spawn()
        .unwrap()
}

fn wait(child: &mut Child) -> ExitStatus {
    let until = deadline();
    while Instant::now() < until {
        if let Some(status) = child.try_wait().unwrap() {
            return status;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    panic!("the process does not end");
}
