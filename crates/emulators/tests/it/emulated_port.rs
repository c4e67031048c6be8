//! The port of an emulated ground station. The symbolic link to a pseudo-terminal: files and links of others
//! are neither replaced nor removed. The TCP port: one client, which cannot block the port by its silence.

use std::fs;
use std::io::Write as _;
use std::net::TcpStream;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::Duration;

use barrelman_emulators::emulated_port::EmulatedPort;

use crate::empty_folder;

/// A pseudo-terminal that does not exist: the kernel assigns no such numbers.
const MISSING_TERMINAL: &str = "/dev/pts/999999999";

/// The path of a port in an empty folder.
fn port_in(name: &str) -> PathBuf {
    empty_folder(&format!("emulated-port-{name}")).join("port")
}

#[track_caller]
fn refused(path: &Path, force: bool, words: &[&str]) {
    let refusal = format!("{:#}", EmulatedPort::pty(path, force).unwrap_err());
    for word in words {
        assert!(refusal.contains(word), "{word:?} is not in {refusal}");
    }
}

/// Whether a link points to a pseudo-terminal that exists.
fn is_port(path: &Path) -> bool {
    fs::read_link(path).is_ok_and(|target| target.starts_with("/dev/pts") && target.exists())
}

#[test]
fn a_port_has_a_link_for_as_long_as_it_lasts() {
    let path = port_in("lasts");
    let port = EmulatedPort::pty(&path, false).unwrap();
    assert!(is_port(&path));
    drop(port);
    assert!(fs::symlink_metadata(&path).is_err());
}

#[test]
fn a_link_of_another_program_is_refused_and_kept() {
    let path = port_in("theirs");
    // Dangling links too, and a link to a terminal that exists.
    for target in ["precious", "/dev/null", "/dev/pts", "/dev/pts/ptmx", "/dev/pts/x", "relative/gone"] {
        symlink(target, &path).unwrap();
        refused(&path, false, &["symbolic link", target, "--force"]);
        assert_eq!(fs::read_link(&path).unwrap(), Path::new(target));
        fs::remove_file(&path).unwrap();
    }
    let other = path.with_file_name("other");
    let _other = EmulatedPort::pty(&other, false).unwrap();
    let terminal = fs::read_link(&other).unwrap();
    refused(&other, false, &["symbolic link", "--force"]);
    assert_eq!(fs::read_link(&other).unwrap(), terminal);
}

#[test]
fn the_link_of_a_killed_emulator_is_replaced() {
    let path = port_in("killed");
    symlink(MISSING_TERMINAL, &path).unwrap();
    let port = EmulatedPort::pty(&path, false).unwrap();
    assert!(is_port(&path));
    drop(port);
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 0);
}

#[test]
fn with_force_a_link_is_replaced_and_what_it_led_to_is_kept() {
    let path = port_in("forced");
    let target = path.with_file_name("precious");
    fs::write(&target, "precious").unwrap();
    symlink(&target, &path).unwrap();
    let port = EmulatedPort::pty(&path, true).unwrap();
    assert!(is_port(&path));
    drop(port);
    assert!(fs::symlink_metadata(&path).is_err());
    assert_eq!(fs::read_to_string(&target).unwrap(), "precious");
}

#[test]
fn no_file_and_no_folder_is_ever_replaced() {
    let path = port_in("file");
    fs::write(&path, "precious").unwrap();
    for force in [false, true] {
        refused(&path, force, &["port", "no symbolic link", "another path"]);
        assert_eq!(fs::read_to_string(&path).unwrap(), "precious");
        refused(path.parent().unwrap(), force, &["no symbolic link"]);
    }
}

#[test]
fn a_link_that_was_replaced_meanwhile_is_not_removed() {
    let path = port_in("replaced");
    let mut port = EmulatedPort::pty(&path, false).unwrap();
    fs::remove_file(&path).unwrap();
    symlink("precious", &path).unwrap();
    port.unplug();
    assert_eq!(fs::read_link(&path).unwrap(), Path::new("precious"));
    assert!(port.plug().is_err());
    drop(port);
    assert_eq!(fs::read_link(&path).unwrap(), Path::new("precious"));
}

#[test]
fn a_port_that_is_plugged_in_again_has_another_terminal() {
    let path = port_in("plugged");
    let mut port = EmulatedPort::pty(&path, false).unwrap();
    let before = fs::read_link(&path).unwrap();
    port.unplug();
    assert!(fs::symlink_metadata(&path).is_err());
    port.plug().unwrap();
    assert!(is_port(&path));
    assert_ne!(fs::read_link(&path).unwrap(), before);
}

/// What the port reads next. Waits for as long as it takes.
fn next_bytes(port: &mut EmulatedPort) -> String {
    let mut buffer = [0; 64];
    loop {
        let read = port.read(&mut buffer, Duration::from_millis(10));
        if read > 0 {
            return String::from_utf8_lossy(&buffer[..read]).into_owned();
        }
    }
}

fn client_of(port: &EmulatedPort) -> TcpStream {
    let url = port.url();
    TcpStream::connect(url.strip_prefix("tcp://").unwrap()).unwrap()
}

#[test]
fn a_silent_client_makes_room_for_another_one() {
    let mut port = EmulatedPort::listen_with("127.0.0.1:0", Duration::ZERO).unwrap();
    let mut first = client_of(&port);
    first.write_all(b"first").unwrap();
    assert_eq!(next_bytes(&mut port), "first");
    let mut second = client_of(&port);
    second.write_all(b"second").unwrap();
    assert_eq!(next_bytes(&mut port), "second");
}

#[test]
fn a_client_that_speaks_keeps_the_port() {
    let mut port = EmulatedPort::listen_with("127.0.0.1:0", Duration::from_secs(3600)).unwrap();
    let mut first = client_of(&port);
    first.write_all(b"first").unwrap();
    assert_eq!(next_bytes(&mut port), "first");
    client_of(&port).write_all(b"second").unwrap();
    first.write_all(b"again").unwrap();
    assert_eq!(next_bytes(&mut port), "again");
}

#[test]
fn a_port_that_other_machines_reach_says_so() {
    for (address, is_public) in [("127.0.0.1:0", false), ("0.0.0.0:0", true)] {
        assert_eq!(EmulatedPort::listen(address).unwrap().is_public(), is_public, "{address}");
    }
}
