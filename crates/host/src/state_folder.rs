//! The folder of what the program makes once and keeps: `$STATE_DIRECTORY` of a service (systemd.exec(5)),
//! otherwise `barrelman` in the user's folder of states (XDG Base Directory Specification).

use std::ffi::OsString;
use std::path::PathBuf;

/// The folder, which need not exist; `None`: the environment names none.
pub fn state_folder() -> Option<PathBuf> {
    folder_of(|name| std::env::var_os(name))
}

fn folder_of(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    // A relative path counts as none.
    let folder = |name| variable(name).map(PathBuf::from).filter(|path| path.is_absolute());
    folder("STATE_DIRECTORY")
        .or_else(|| folder("XDG_STATE_HOME").map(|states| states.join("barrelman")))
        .or_else(|| folder("HOME").map(|home| home.join(".local/state/barrelman")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_service_has_its_own_folder_and_a_user_one_below_home() {
        for (variables, expected) in [
            (&[("HOME", "/own")][..], Some("/own/.local/state/barrelman")),
            (&[("HOME", "/own"), ("XDG_STATE_HOME", "/s")], Some("/s/barrelman")),
            (&[("HOME", "/own"), ("XDG_STATE_HOME", "s")], Some("/own/.local/state/barrelman")),
            (&[("HOME", "/"), ("STATE_DIRECTORY", "/var/lib/barrelman")], Some("/var/lib/barrelman")),
            (&[], None),
        ] {
            let value =
                |name: &str| variables.iter().find(|(own, _)| *own == name).map(|(_, value)| value.into());
            assert_eq!(folder_of(value), expected.map(PathBuf::from), "{variables:?}");
        }
    }
}
