//! What must not be there: a room that knows the protocol of one vehicle; a gateway or a snapshot that knows
//! the server.

use std::fs;
use std::path::Path;

/// Adds the source files of a folder and the folders in it.
fn add_sources(folder: &Path, sources: &mut Vec<(String, String)>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            add_sources(&path, sources);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            sources.push((path.to_string_lossy().into_owned(), fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn only_the_emulators_and_five_named_files_name_the_protocol_of_a_vehicle() {
    let crates = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let mut sources = Vec::new();
    for folder in ["station/src", "console-server/src", "emulators/src"] {
        add_sources(&crates.join(folder), &mut sources);
    }
    assert!(sources.len() > 100, "only {} files", sources.len());
    let names = [
        "barrelman_wire::fotokite",
        "Protocol::Fotokite",
        "barrelman_wire::mavlink",
        "Protocol::Mavlink",
        "Protocol::Onvif",
    ];
    // The tracking camera is no vehicle: nothing moves by it.
    let without_camera =
        |text: &str| text.replace("mavlink::tracking_camera", "").replace("mavlink::TrackingCamera", "");
    let knows = |text: &str| {
        let text = without_camera(text);
        names.iter().any(|name| text.contains(name))
    };
    let (emulators, others): (Vec<_>, Vec<_>) =
        sources.iter().filter(|(_, text)| knows(text)).partition(|(path, _)| path.contains("/emulators/"));
    assert!(!emulators.is_empty(), "the test finds what it looks for");
    // The addresses of a MAVLink link are keys of the configuration, each API has a proof of its own of who
    // asks, and the check asks vehicles what they have.
    let known = [
        "config/mavlink.rs",
        "station/src/secrets.rs",
        "commands/check_equipment.rs",
        "commands/check_gimbal.rs",
        "commands/check_over_http.rs",
    ];
    let is_known = |path: &str| known.iter().any(|known| path.ends_with(known));
    let others: Vec<&String> = others.iter().map(|(path, _)| path).filter(|path| !is_known(path)).collect();
    assert!(others.is_empty(), "{others:?}");
}

#[test]
fn gateway_and_snapshot_do_not_name_the_server() {
    let console = Path::new(env!("CARGO_MANIFEST_DIR")).join("../console-server/src");
    let mut sources = Vec::new();
    for folder in ["operator", "snapshot"] {
        add_sources(&console.join(folder), &mut sources);
    }
    assert!(sources.len() > 15, "only {} files", sources.len());
    for (path, text) in sources {
        let others = text.replace("crate::test_scenes", "");
        assert!(!others.contains("crate::"), "{path}");
    }
}
