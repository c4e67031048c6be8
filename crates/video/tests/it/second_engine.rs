//! Video by GStreamer: `barrelman-media` beside the running program.

use std::fs;
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::process::Command;
use std::time::Duration;

use barrelman_video::VideoState;
use barrelman_video::annexb;
use barrelman_video::media::MediaProgram;
use barrelman_video::mode::DecodeMode;
use barrelman_vocab::unit::EncodedUnit;

use crate::clips;
use crate::live::{Delivered, SOON, start, wait_for};

/// Whether `barrelman-media` is beside the running program. Where it is not, the test of this name runs in a
/// link to the running program that has `barrelman-media` beside it. The other tests of this program go
/// without it.
fn has_media(test: &str) -> bool {
    if MediaProgram::installed().is_some() {
        return true;
    }
    let program = std::env::current_exe().unwrap();
    let media = program.with_file_name("../barrelman-media");
    if !media.is_file() {
        clips::skip("barrelman-media is not built (cargo build -p barrelman-media)");
        return false;
    }
    let folder = clips::output(&format!("{}-{}", test.replace("::", "-"), std::process::id()));
    fs::create_dir_all(&folder).unwrap();
    let link = folder.join("it");
    fs::hard_link(&program, &link).unwrap();
    fs::hard_link(media, folder.join("barrelman-media")).unwrap();
    let run = Command::new(link).args(["--exact", test, "--nocapture"]).output().unwrap();
    fs::remove_dir_all(folder).unwrap();
    let output = [run.stdout, run.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(run.status.success() && output.contains("1 passed"), "{output}");
    false
}

/// The units of a clip whose head is cut off: up to its second half, it had the only IDR picture.
fn headless_units(name: &str, x264: &str) -> Option<Vec<EncodedUnit>> {
    let file = clips::output(&format!("{name}-{}.ts", std::process::id()));
    let options =
        format!("-f lavfi -i testsrc2=s=320x240:r=25:d=4 -pix_fmt yuv420p -c:v libx264 -x264-params {x264}");
    let mut ffmpeg = Command::new("ffmpeg");
    ffmpeg.args(["-v", "error", "-nostdin", "-y"]).args(options.split(' ')).arg(&file);
    let Ok(run) = ffmpeg.output() else {
        clips::skip("ffmpeg is not installed");
        return None;
    };
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    let clip = fs::read(&file).unwrap();
    let half = clip.len() / 2 / 188 * 188;
    fs::write(&file, &clip[half..]).unwrap();
    let units = clips::units_of(&file);
    fs::remove_file(file).unwrap();
    Some(units)
}

fn check_without_idr(name: &str, x264: &str) {
    let Some(units) = headless_units(name, x264) else { return };
    assert!(units.iter().all(|unit| annexb::lacks_key_slice(&unit.payload)), "there is an IDR picture");
    let first_key = units.iter().position(|unit| unit.key).unwrap();
    let (frames, errors) = clips::decode(&units, DecodeMode::Live);
    assert_eq!(errors, []);
    // A refresh takes as long as ten pictures.
    let expected = units.len() - first_key - 12;
    assert!(frames.len() >= expected, "{} of {} units, {expected} expected", frames.len(), units.len());
}

#[test]
fn h264_with_periodic_intra_refresh_is_decoded_from_its_middle() {
    if has_media("second_engine::h264_with_periodic_intra_refresh_is_decoded_from_its_middle") {
        check_without_idr("refresh", "intra-refresh=1:keyint=10:bframes=0");
    }
}

#[test]
fn h264_with_open_groups_of_pictures_is_decoded_from_its_middle() {
    if has_media("second_engine::h264_with_open_groups_of_pictures_is_decoded_from_its_middle") {
        check_without_idr("open", "open-gop=1:keyint=10:min-keyint=10:scenecut=0:bframes=2:b-adapt=0");
    }
}

/// Sends a few pictures of a multipart stream, and closes the connection.
fn send_pictures(mut stream: TcpStream, picture: &[u8]) {
    let _ = stream.read(&mut [0; 4096]);
    let mut sent =
        b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=next\r\n\r\n".to_vec();
    for _ in 0..5 {
        let head = format!("--next\r\nContent-Type: image/jpeg\r\nContent-Length: {}\r\n\r\n", picture.len());
        sent.extend([head.as_bytes(), picture, b"\r\n"].concat());
        // Whoever does not read any more has what it wanted.
        let _ = stream.write_all(&sent);
        sent.clear();
        std::thread::sleep(Duration::from_millis(40));
    }
}

#[test]
fn an_http_camera_that_closes_its_connection_is_connected_again() {
    if !has_media("second_engine::an_http_camera_that_closes_its_connection_is_connected_again") {
        return;
    }
    let picture = fs::read(clips::fixture("jpeg/1.jpg")).unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            send_pictures(stream.unwrap(), &picture);
        }
    });
    let (handle, from, _) = start(&format!("http://{address}/video"));
    for _ in 0..2 {
        let up = wait_for(&from, SOON, |delivered| match delivered {
            Delivered::State(VideoState::Up) => Some(()),
            Delivered::State(VideoState::Ended | VideoState::Failed(_)) => panic!("the video has ended"),
            _ => None,
        });
        assert!(up.is_some(), "no picture");
        let reason = wait_for(&from, SOON, |delivered| match delivered {
            Delivered::State(VideoState::Lost { reason }) => Some(reason),
            Delivered::State(state @ (VideoState::Ended | VideoState::Failed(_))) => panic!("{state:?}"),
            _ => None,
        });
        assert_eq!(reason.as_deref(), Some("it ended its stream"));
    }
    assert_eq!(handle.stop(), Ok(()));
}
