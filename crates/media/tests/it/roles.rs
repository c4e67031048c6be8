//! Start and end of the program.

use std::process::{Command, Stdio};

use barrelman_media_protocol::channel::ChannelError;
use barrelman_media_protocol::decoder::{DecoderList, FromDecoder};
use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::role::{BUILD, DecoderSettings, Role};
use barrelman_media_protocol::share::{FromShare, ShareSettings};

use crate::media::Media;

const H264: DecoderSettings = DecoderSettings { format: CodedFormat::H264, is_live: true };

#[test]
fn a_program_without_a_channel_says_what_it_is_for() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_barrelman-media"));
    let done = command.stdin(Stdio::null()).output().unwrap();
    assert_eq!(done.status.code(), Some(2));
    let text = String::from_utf8(done.stderr).unwrap();
    assert!(text.contains("is started by `barrelman`") && text.lines().count() == 1, "{text}");
}

#[test]
fn a_program_of_another_build_is_refused() {
    let mut media = Media::of_build("0.0.0", Role::Decoder(H264));
    let (message, _) = media.decoder_message().unwrap();
    let FromDecoder::NoDecoder { reason, remedy } = message else { panic!("{message:?}") };
    assert_eq!(reason, "is of another build than barrelman");
    assert_eq!(remedy, "Install both together");
    assert!(matches!(media.decoder_message(), Err(ChannelError::Closed)));
}

#[test]
fn a_share_of_another_build_or_without_a_socket_is_refused() {
    let settings = ShareSettings { path: "/boat".to_owned(), password: None };
    let cases = [("0.0.0", "another build"), (BUILD, "no socket to listen on")];
    for (build, expected) in cases {
        let mut media = Media::of_build(build, Role::Share(settings.clone()));
        let (message, _) = media.receive::<FromShare>().unwrap().unwrap();
        let FromShare::Failed { reason, .. } = message else { panic!("{message:?}") };
        assert!(reason.contains(expected), "{reason}");
        assert!(media.end().success());
    }
}

#[test]
fn all_formats_have_a_decoder() {
    let mut media = Media::start(Role::ListDecoders);
    let (list, _) = media.receive::<DecoderList>().unwrap().unwrap();
    assert!(list.version.starts_with("1."), "{list:?}");
    let formats: Vec<_> = list.decoders.iter().map(|(format, _)| *format).collect();
    assert_eq!(formats, CodedFormat::ALL);
    assert!(list.decoders.iter().all(|(_, decoder)| decoder.is_some()), "{list:?}");
    assert!(media.end().success());
}

#[test]
fn a_decoder_ends_with_the_channel() {
    assert!(Media::decoder(CodedFormat::H264, true).close().success());
}

#[test]
fn a_decoder_has_given_up_its_rights() {
    let media = Media::decoder(CodedFormat::H264, true);
    let status = std::fs::read_to_string(format!("/proc/{}/status", media.id())).unwrap();
    let value = |key: &str| {
        let line = status.lines().find(|line| line.starts_with(key)).unwrap();
        line.split_whitespace().nth(1).unwrap().to_owned()
    };
    assert_eq!(value("NoNewPrivs:"), "1");
    assert_eq!(value("Seccomp:"), "2");
}
