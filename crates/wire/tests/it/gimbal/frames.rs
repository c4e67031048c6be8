//! Frames in a stream of bytes.

use barrelman_vocab::VehicleRates;
use barrelman_vocab::mavlink::Address;
use barrelman_wire::mavlink::frame::{FrameReader, FrameWriter};
use barrelman_wire::mavlink::{Command, Gimbal, Wanted};
use proptest::prelude::*;

fn packets(count: u8) -> Vec<Vec<u8>> {
    let mut writer = FrameWriter::new(Address::new(1, 1), None);
    let commands = [
        Command::Heartbeat,
        Command::Request { to: Address::new(1, 1), message: Wanted::Attitude },
        Command::Rates(Gimbal::ALL, VehicleRates::REST),
    ];
    (0..count).map(|index| commands[usize::from(index) % 3].encode(&mut writer)).collect()
}

fn read(reader: &mut FrameReader, bytes: &[u8]) -> usize {
    let mut found = 0;
    reader.read(bytes, |_| found += 1);
    found
}

#[test]
fn a_frame_behind_a_false_beginning_is_found_at_once() {
    let packet = packets(1).remove(0);
    // The first byte and a length of 255: what follows might be its payload.
    for garbage in [&[0xfd, 0xff][..], &[0xfd, 0xff, 0, 0, 0, 0, 0], &[0xfe, 0xff], &[0xfd; 40]] {
        let mut reader = FrameReader::default();
        assert_eq!(read(&mut reader, &[garbage, &packet].concat()), 1, "{garbage:02x?}");
        assert_eq!(read(&mut reader, &packet), 1);
    }
}

#[test]
fn a_damaged_frame_is_not_read() {
    let packet = packets(3).remove(2);
    for index in 0..packet.len() {
        let mut damaged = packet.clone();
        damaged[index] ^= 0x20;
        assert_eq!(read(&mut FrameReader::default(), &damaged), 0, "byte {index}");
    }
}

proptest! {
    #[test]
    fn all_frames_are_found_however_the_stream_is_cut(
        cuts in prop::collection::vec(1_usize..40, 1..60),
        garbage in prop::collection::vec(0_u8..0xfd, 0..30),
    ) {
        let all = packets(12);
        let bytes = all.join(&garbage[..]);
        let (mut reader, mut found, mut rest) = (FrameReader::default(), 0, &bytes[..]);
        for cut in cuts.into_iter().cycle() {
            let (piece, after) = rest.split_at(cut.min(rest.len()));
            found += read(&mut reader, piece);
            rest = after;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(found, all.len());
    }
}
