//! Runs the program `barrelman`, and checks how it ends.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs the program in the current folder.
pub(crate) fn barrelman(arguments: &[&str]) -> Output {
    barrelman_in(Path::new("."), arguments)
}

/// Runs the program in a folder.
pub(crate) fn barrelman_in(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_barrelman")).current_dir(folder).args(arguments).output().unwrap()
}

/// The standard output of a run that must have succeeded.
#[track_caller]
pub(crate) fn succeeded(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The standard error of a run that must have failed with this exit code and a message that contains all
/// words.
#[track_caller]
pub(crate) fn failed(output: &Output, code: i32, words: &[&str]) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{message}");
    for word in words {
        assert!(message.contains(word), "{word:?} is not in {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
    message
}

/// An empty folder for one test. The name must differ from those of all other tests.
pub(crate) fn empty_folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A path as an argument.
pub(crate) fn argument(path: &Path) -> &str {
    path.to_str().unwrap()
}
