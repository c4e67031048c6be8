//! Passwords: never printed or recorded, and read from a file or the environment.

use std::fs::{File, Permissions};
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::{SocketAddr, TcpListener};
use std::os::unix::fs::PermissionsExt as _;
use std::process::{Command, Output};
use std::sync::mpsc::{Receiver, channel};
use std::thread;

use barrelman_host::input::is_readable_by_others;
use barrelman_trial::records::{Entry, RecordingReader};

use crate::program::{argument, empty_folder};

const PASSWORD: &str = "hunter2";
/// `admin:hunter2`.
const BASIC: &str = "Basic YWRtaW46aHVudGVyMg==";

fn barrelman(options: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_barrelman"));
    command.args(options).env("BARRELMAN_TEST_LOGIN", format!("admin:{PASSWORD}")).output().unwrap()
}

/// Runs a command that must fail without printing the password. Returns its standard output and standard
/// error.
#[track_caller]
fn refused(options: &[&str], words: &str) -> String {
    let output = barrelman(options);
    let message = [output.stdout, output.stderr].concat();
    let message = String::from_utf8(message).unwrap();
    assert!(!output.status.success() && message.contains(words), "{message}\nexpected {words}");
    assert!(!message.contains(PASSWORD), "{message}");
    message
}

#[test]
fn the_password_of_a_link_is_refused_and_not_repeated() {
    let folder = empty_folder("secrets-link");
    let hidden = "tcp://***@127.0.0.1:9\" has a login";
    let url = format!("tcp://user:{PASSWORD}@127.0.0.1:9");
    let clip = concat!("file:", env!("CARGO_MANIFEST_DIR"), "/../../fixtures/video/baseline.mp4");
    let record = folder.join("run.mcap");
    refused(&["run", "--video", clip, "--link", &url, "--record", argument(&record)], hidden);
    assert!(!record.exists());
    // JSON quotes the quotation mark.
    refused(&["check", "--video", clip, "--link", &url, "--json"], "tcp://***@127.0.0.1:9");
    let config = folder.join("barrelman.toml");
    std::fs::write(&config, format!("[link]\nurl = \"{url}\"\n")).unwrap();
    refused(&["run", argument(&config), "--video", clip], hidden);
    // The message shows the line with the mistake.
    std::fs::write(&config, format!("[link]\nurll = \"{url}\"\n")).unwrap();
    refused(&["run", argument(&config), "--video", clip], "tcp://***@127.0.0.1:9");
}

/// A camera that refuses every login, and the queue of `Authorization` values that it receives.
fn camera() -> (SocketAddr, Receiver<String>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let (to, logins) = channel();
    thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream = stream.unwrap();
            let mut lines = BufReader::new(stream.try_clone().unwrap()).lines();
            let mut sequence = String::new();
            while let Some(Ok(line)) = lines.next() {
                match line.split_once(": ") {
                    Some((key, value)) if key.eq_ignore_ascii_case("cseq") => sequence = value.to_owned(),
                    Some((key, value)) if key.eq_ignore_ascii_case("authorization") => {
                        let _ = to.send(value.to_owned());
                    }
                    None if line.is_empty() => {
                        let answer = format!(
                            "RTSP/1.0 401 Unauthorized\r\nCSeq: {sequence}\r\n\
                             WWW-Authenticate: Basic realm=\"camera\"\r\n\r\n"
                        );
                        if stream.write_all(answer.as_bytes()).is_err() {
                            break;
                        }
                    }
                    _ => {}
                }
            }
        }
    });
    (address, logins)
}

#[test]
fn a_login_comes_from_a_file_or_the_environment_and_goes_to_the_camera_alone() {
    let folder = empty_folder("secrets-video");
    let login = folder.join("login");
    std::fs::write(&login, format!("admin:{PASSWORD}\nnot this line\n")).unwrap();
    std::fs::set_permissions(&login, Permissions::from_mode(0o600)).unwrap();
    assert!(!is_readable_by_others(&login));
    let (address, logins) = camera();
    let url = format!("rtsp://{address}/live");
    let refuses = "does not let us in";
    let basic = folder.join("basic.toml");
    std::fs::write(&basic, "[video]\nallow_basic_login = true\n").unwrap();

    let options = ["check", "--video", &url, "--video-login-file", argument(&login), "--json"];
    refused(&options, "allow_basic_login");
    assert!(logins.try_recv().is_err(), "the password was sent in clear");

    let message = refused(&[&options[..], &[argument(&basic)]].concat(), refuses);
    assert_eq!(logins.recv().unwrap(), BASIC);
    assert!(!message.contains("can be read by others"), "{message}");

    let config = folder.join("barrelman.toml");
    std::fs::write(
        &config,
        format!("[video]\nurl = \"{url}\"\nallow_basic_login = true\nlogin_env = \"BARRELMAN_TEST_LOGIN\"\n"),
    )
    .unwrap();
    refused(&["check", argument(&config)], refuses);
    assert_eq!(logins.recv().unwrap(), BASIC);

    std::fs::set_permissions(&login, Permissions::from_mode(0o644)).unwrap();
    let login_file = login.display();
    std::fs::write(
        &config,
        format!("[video]\nurl = \"{url}\"\nallow_basic_login = true\nlogin_file = \"{login_file}\"\n"),
    )
    .unwrap();
    let record = folder.join("run.mcap");
    let message = refused(&["run", argument(&config), "--record", argument(&record)], refuses);
    assert_eq!(logins.recv().unwrap(), BASIC);
    assert!(message.contains("can be read by others: run `chmod 600"), "{message}");
    let Some(Ok(Entry::Start(start))) = RecordingReader::new(File::open(&record).unwrap()).next() else {
        panic!("it begins with its start")
    };
    assert!(
        start.videos.first.address.starts_with("rtsp://***@127.0.0.1")
            && start.configuration.contains("login_file")
    );
    assert!(!format!("{start:?}").contains(PASSWORD), "{start:?}");
}

#[test]
fn a_login_goes_to_the_server_that_its_file_names() {
    let folder = empty_folder("secrets-server");
    let login = folder.join("login");
    let (address, logins) = camera();
    let url = format!("rtsp://{address}/live");
    std::fs::write(&login, format!("admin:{PASSWORD}\nhost 127.0.0.1:9\n")).unwrap();
    refused(
        &["check", "--video", &url, "--video-login-file", argument(&login)],
        "the login is for 127.0.0.1:9",
    );
    assert!(logins.try_recv().is_err());
}

#[test]
fn an_address_with_a_password_that_is_not_encoded_is_refused_and_not_printed() {
    for text in ["se#{}@127.0.0.1:9/x", "se/{}@127.0.0.1:9/x", "se?{}@127.0.0.1:9/x", "se@{}@127.0.0.1:9/x"] {
        let rest = text.replace("{}", PASSWORD);
        refused(&["check", "--video", &format!("rtsp://admin:{rest}")], "%23");
        refused(&["check", "--link", &format!("tcp://admin:{rest}")], "has an @");
    }
}

#[test]
fn a_login_that_cannot_be_had_is_named_and_not_repeated() {
    let folder = empty_folder("secrets-refused");
    let (login, config) = (folder.join("login"), folder.join("barrelman.toml"));
    std::fs::write(&login, format!("{PASSWORD}\n")).unwrap();
    let url = "rtsp://127.0.0.1:9/live";
    let run = |video: &str, words: &str| {
        refused(&["run", "--video", video, "--video-login-file", argument(&login)], words)
    };
    run(url, "write user:password");
    run("sim:open", "takes no login");
    std::fs::write(&login, format!("admin:{PASSWORD}\n")).unwrap();
    run(&format!("rtsp://root:{PASSWORD}@127.0.0.1:9/live"), "given twice");
    refused(&["run", "--video", url, "--video-login-file", "nowhere"], "there is no file nowhere");
    std::fs::write(&config, "[video]\nlogin_env = \"BARRELMAN_TEST_UNSET\"\n").unwrap();
    refused(&["run", argument(&config), "--video", url], "BARRELMAN_TEST_UNSET");
    std::fs::write(&config, "[video]\nlogin_env = \"A\"\nlogin_file = \"b\"\n").unwrap();
    refused(&["run", argument(&config), "--video", url], "both given");
}
