//! The library on a folder of its own.

use std::os::unix::fs::symlink;

use barrelman_pilot::CommandPath;
use barrelman_trial::records::{RecordedVideo, RecordingStart, RecordingWriter};
use barrelman_vocab::VehicleProfile;

use super::*;

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
        let start = RecordingStart {
            program: "0.1.0".to_owned(),
            monotonic_ns: 0,
            unix_ns: 0,
            configuration: String::new(),
            videos: RecordedVideo::only("sim:open", true),
            link: String::new(),
            command_path: CommandPath::DryRun,
            trial: None,
        };
        let file = File::create(self.folder.join(name)).unwrap();
        let mut writer = RecordingWriter::begin(file, &start, &VehicleProfile::fotokite_pro()).unwrap();
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
fn a_recording_that_was_cut_off_is_summed_up_once_by_the_program() {
    let scene = Scene::new("cut", "");
    let (program, calls) = (scene.folder.join("program"), scene.folder.join("calls"));
    let json = serde_json::json!({ "sortie": Sortie { length_s: 7.5, ..Sortie::default() } });
    let script = format!("#!/bin/sh\necho \"$@\" >> {}\ncat <<'END'\n{json}\nEND\n", calls.display());
    write_program(&program, &script);
    scene.record("whole.mcap", true);
    scene.record("cut.mcap", false);
    let library = Library::new(scene.folder.clone(), program.clone());
    assert_eq!(library.sortie(&name("whole.mcap")).unwrap().unwrap().video, "sim:open");
    for _ in 0..2 {
        assert_eq!(library.sortie(&name("cut.mcap")).unwrap().unwrap().length_s, 7.5);
    }
    let expected = format!("library --json {}\n", scene.folder.join("cut.mcap").display());
    assert_eq!(std::fs::read_to_string(calls).unwrap(), expected);
    write_program(&program, "#!/bin/sh\necho 'it holds no run of this program' >&2\nexit 1\n");
    let reason = Library::new(scene.folder.clone(), program).sortie(&name("cut.mcap")).unwrap();
    assert_eq!(reason, Err("it holds no run of this program".to_owned()));
    assert!(library.sortie(&name("absent.mcap")).is_err());
}

fn write_program(path: &Path, script: &str) {
    use std::os::unix::fs::PermissionsExt as _;
    std::fs::write(path, script).unwrap();
    std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
}
