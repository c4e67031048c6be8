//! The library on a folder of its own.

use std::os::unix::fs::symlink;
use std::sync::Arc;

use axum::body::Body;
use axum::http::Request;
use barrelman_pilot::{CommandPath, Mode, Outcome};
use barrelman_trial::records::{Entry, RecordedOutcome, RecordedVideo, RecordingStart, RecordingWriter};
use barrelman_vocab::unit::{Rotation, UnitCodec};
use barrelman_vocab::video::{Capture, CaptureQuality};
use barrelman_vocab::{EncodedUnit, VehicleProfile, VehicleRates, VideoNumber};
use tower::ServiceExt as _;

use super::*;
use crate::in_memory::{InMemory, LIVE, WATCH_TOKEN, block_on};
use crate::test_scenes::{at, idle};

struct Scene {
    folder: PathBuf,
    library: Library,
}

impl Scene {
    /// `program`: what exports.
    fn new(name: &str, program: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("barrelman-library-{}-{name}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Self { library: Library::new(folder.clone(), program.into()), folder }
    }

    fn record(&self, name: &str, is_complete: bool) {
        let file = File::create(self.folder.join(name)).unwrap();
        let mut writer = RecordingWriter::begin(file, &start(), &VehicleProfile::fotokite_pro()).unwrap();
        writer.flush().unwrap();
        if is_complete {
            writer.finish().unwrap();
        }
    }

    fn names(&self) -> Vec<(String, RecordingState)> {
        let listed = self.library.list().unwrap();
        listed.into_iter().map(|listed| (listed.name.as_str().to_owned(), listed.state)).collect()
    }

    fn film_when_done(&self, name: &RecordingName) -> FilmState {
        loop {
            match self.library.film_state(name) {
                FilmState::BeingMade => std::thread::yield_now(),
                done => return done,
            }
        }
    }
}

impl Drop for Scene {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn start() -> RecordingStart {
    RecordingStart {
        program: "0.1.0".to_owned(),
        monotonic_ns: 0,
        unix_ns: 0,
        configuration: String::new(),
        videos: RecordedVideo::only("sim:open", true),
        link: String::new(),
        command_path: CommandPath::DryRun,
        trial: None,
    }
}

fn name(text: &str) -> RecordingName {
    text.parse().unwrap()
}

#[test]
fn recordings_are_listed_and_nothing_else() {
    let scene = Scene::new("listed", "/bin/true");
    scene.record("a.mcap", true);
    scene.record("b.mcap", false);
    std::fs::write(scene.folder.join("notes.txt"), "no recording").unwrap();
    std::fs::create_dir(scene.folder.join("folder.mcap")).unwrap();
    symlink("/etc/hostname", scene.folder.join("link.mcap")).unwrap();
    let expected = [("b.mcap", RecordingState::CutOff), ("a.mcap", RecordingState::Complete)];
    assert_eq!(scene.names(), expected.map(|(name, state)| (name.to_owned(), state)));
    assert_eq!(scene.library.file(&name("link.mcap"), "recording.mcap"), None);
    assert_eq!(scene.library.file(&name("a.mcap"), "../../etc/passwd"), None);
    assert!(scene.library.file(&name("a.mcap"), "recording.mcap").is_some());
}

#[test]
fn a_file_without_a_recording_in_it_is_listed_with_the_reason() {
    let scene = Scene::new("empty", "");
    let program = scene.folder.join("program");
    write_program(&program, "#!/bin/sh\necho 'it holds no run of this program' >&2\nexit 1\n");
    std::fs::write(scene.folder.join("empty.mcap"), "").unwrap();
    assert_eq!(scene.names(), [("empty.mcap".to_owned(), RecordingState::CutOff)]);
    let library = Library::new(scene.folder.clone(), program);
    let reason = library.observed_sortie(&name("empty.mcap")).unwrap().unwrap_err();
    assert_eq!(reason, "it holds no run of this program");
}

#[test]
fn a_folder_that_does_not_exist_holds_no_recordings() {
    let library = Library::new("/nowhere/at/all".into(), "/bin/true".into());
    assert!(library.list().unwrap().is_empty());
}

#[test]
fn a_recording_is_renamed_and_deleted_with_its_film() {
    let scene = Scene::new("renamed", "/bin/true");
    scene.record("a.mcap", true);
    scene.record("c.mcap", true);
    std::fs::create_dir(scene.folder.join("a.export")).unwrap();
    std::fs::write(scene.folder.join("a.export").join(FILM), "film").unwrap();
    assert!(scene.library.rename(&name("a.mcap"), &name("c.mcap")).is_err());
    scene.library.rename(&name("a.mcap"), &name("b.mcap")).unwrap();
    assert_eq!(scene.library.film_state(&name("b.mcap")), FilmState::Ready);
    assert!(scene.library.file(&name("b.mcap"), FILM).is_some());
    scene.library.delete(&name("b.mcap")).unwrap();
    assert!(!scene.folder.join("b.export").exists());
    assert_eq!(scene.names().len(), 1);
}

#[test]
fn a_recording_that_is_being_written_stays() {
    let scene = Scene::new("written", "/bin/true");
    let mut output = barrelman_host::output::OutputFile::open(&scene.folder.join("now.mcap"), false).unwrap();
    std::io::Write::write_all(&mut output, b"begun").unwrap();
    assert_eq!(scene.names(), [("now.mcap".to_owned(), RecordingState::BeingRecorded)]);
    assert!(scene.library.delete(&name("now.mcap")).is_err());
}

#[test]
fn a_film_that_is_not_made_is_told() {
    let scene = Scene::new("films", "/bin/true");
    scene.record("a.mcap", true);
    assert_eq!(scene.library.film_state(&name("a.mcap")), FilmState::None);
    scene.library.make_film(&name("a.mcap")).unwrap();
    assert_eq!(scene.film_when_done(&name("a.mcap")), FilmState::Failed);
    let missing = Scene::new("programs", "/nowhere/at/all");
    assert!(missing.library.make_film(&name("a.mcap")).is_err());
}

#[test]
fn one_film_is_made_at_a_time() {
    let scene = Scene::new("one-film", "");
    let program = scene.folder.join("program");
    write_program(&program, "#!/bin/sh\nexec sleep 600\n");
    let library = Library::new(scene.folder.clone(), program);
    library.make_film(&name("a.mcap")).unwrap();
    library.make_film(&name("a.mcap")).unwrap();
    let error = library.make_film(&name("b.mcap")).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::ResourceBusy);
    assert!(error.to_string().contains("a.mcap is being made"), "{error}");
    assert_eq!(library.film_state(&name("b.mcap")), FilmState::None);
}

#[test]
fn a_recording_that_was_cut_off_is_summed_up_once_by_the_program() {
    let scene = Scene::new("cut", "");
    let (program, calls) = (scene.folder.join("program"), scene.folder.join("calls"));
    let json = serde_json::json!({ "sortie": Sortie { length_s: 7.5, ..Sortie::default() } });
    let script = format!("#!/bin/sh\necho \"$@\" >> {}\ncat <<'END'\n{json}\nEND\n", calls.display());
    write_program(&program, &script);
    scene.record("whole.mcap", true);
    scene.record("cut.mcap", false);
    let library = Library::new(scene.folder.clone(), program.clone());
    assert_eq!(library.stored_sortie(&name("whole.mcap")).unwrap().unwrap().video, "sim:open");
    for _ in 0..2 {
        assert_eq!(library.observed_sortie(&name("cut.mcap")).unwrap().unwrap().length_s, 7.5);
    }
    let expected = format!("library --json {}\n", scene.folder.join("cut.mcap").display());
    assert_eq!(std::fs::read_to_string(calls).unwrap(), expected);
    write_program(&program, "#!/bin/sh\necho 'it holds no run of this program' >&2\nexit 1\n");
    let reason = Library::new(scene.folder.clone(), program).observed_sortie(&name("cut.mcap")).unwrap();
    assert_eq!(reason, Err("it holds no run of this program".to_owned()));
    assert!(library.observed_sortie(&name("absent.mcap")).is_err());
}

/// A recording of one picture that browsers cannot decode.
fn record_picture(folder: &Path, name: &str, codec: UnitCodec) {
    let capture = Capture { at: at(10), quality: CaptureQuality::Sensor };
    let unit = EncodedUnit {
        epoch: 0,
        index: 0,
        capture,
        key: true,
        shown: true,
        rotation: Rotation::None,
        codec,
        payload: b"a picture".as_slice().into(),
    };
    let outcome = RecordedOutcome::new(0, &idle(at(20)), VehicleRates::REST);
    let file = File::create(folder.join(name)).unwrap();
    let mut writer = RecordingWriter::begin(file, &start(), &VehicleProfile::fotokite_pro()).unwrap();
    writer.write(&Entry::Unit(VideoNumber::First, unit)).unwrap();
    writer.write(&Entry::Outcome(outcome)).unwrap();
    writer.finish().unwrap();
}

#[test]
fn no_picture_is_encoded_while_the_camera_is_engaged() {
    let scene = Scene::new("encoded", "/bin/true");
    record_picture(&scene.folder, "png.mcap", UnitCodec::Png);
    record_picture(&scene.folder, "h264.mcap", UnitCodec::H264AnnexB);
    record_picture(&scene.folder, "jpeg.mcap", UnitCodec::Jpeg);
    let library = Library::new(scene.folder.clone(), "/bin/true".into());
    let mut session = InMemory::with_library(LIVE, library);
    for (mode, part, status) in [
        (Mode::Idle, "png.mcap/part/0", 200),
        (Mode::Idle, "h264.mcap/part/0?form=jpeg", 200),
        (Mode::Servoing, "png.mcap/part/0", 409),
        (Mode::Servoing, "h264.mcap/part/0?form=jpeg", 409),
        (Mode::Servoing, "h264.mcap/part/0", 200),
        (Mode::Servoing, "jpeg.mcap/part/0?form=jpeg", 200),
        (Mode::Servoing, "png.mcap/thumbnail.jpg", 409),
    ] {
        session.step(&Outcome { mode, ..idle(at(0)) });
        let request = Request::get(format!("/api/v1/recordings/{part}"))
            .header("host", "127.0.0.1:8480")
            .header("authorization", format!("Bearer {WATCH_TOKEN}"))
            .body(Body::empty());
        let router = crate::routes::router(Arc::clone(&session.console));
        let answer = block_on(router.oneshot(request.unwrap())).unwrap();
        assert_eq!(answer.status().as_u16(), status, "{mode:?} {part}");
    }
}

fn write_program(path: &Path, script: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::write(path, script).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
}
