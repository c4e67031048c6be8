use super::*;

fn parsed(text: &str) -> VideoUrl {
    VideoUrl::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"))
}

fn check_file(text: &str, path: &str, fps: Option<f64>, faults: &str) {
    let url = parsed(text);
    assert!(url.source == VideoSource::File(path.into()), "{text}: {url:?}");
    assert_eq!((url.fps, url.faults.to_string()), (fps, faults.to_owned()), "{text}");
}

#[test]
fn a_path_may_be_bare_or_behind_a_scheme() {
    check_file("clip.mp4", "clip.mp4", None, "");
    check_file("file:clip.mp4", "clip.mp4", None, "");
    check_file("file:///videos/clip.mp4", "/videos/clip.mp4", None, "");
    check_file("/a folder/of:pictures", "/a folder/of:pictures", None, "");
}

#[test]
fn options_of_a_file_are_taken_off_only_if_they_are_ours() {
    check_file("frames?fps=12.5", "frames", Some(12.5), "");
    check_file("a.mp4?fault=stall@12.5s,drop@3+2", "a.mp4", None, "stall@12.5,drop@3+2");
    check_file("a.mp4?fps=5&fault=stall@1", "a.mp4", Some(5.0), "stall@1");
    check_file("what?.mp4", "what?.mp4", None, "");
    check_file("what?fps=5&more=1", "what?fps=5&more=1", None, "");
}

#[test]
fn a_file_of_exactly_that_name_wins() {
    let path = std::env::temp_dir().join(format!("barrelman-{}?fps=5", std::process::id()));
    std::fs::write(&path, "").unwrap();
    let url = VideoUrl::parse(&path.display().to_string());
    std::fs::remove_file(&path).unwrap();
    assert!(url.unwrap().source == VideoSource::File(path));
}

#[test]
fn an_rtsp_address_keeps_its_own_options_and_loses_ours() {
    let url = parsed("rtsp://cam.example:8554/live?profile=2&fault=stall@3&fps=9");
    assert_eq!(url.to_string(), "rtsp://cam.example:8554/live?profile=2&fps=9&fault=stall@3");
    let VideoSource::Rtsp { address, login: None } = url.source else { panic!("it is RTSP") };
    assert_eq!(address.as_str(), "rtsp://cam.example:8554/live?profile=2");
}

#[test]
fn a_stream_in_tls_is_reached_through_a_relay_and_shown_as_itself() {
    let url = parsed("rtsps://u:secret@cam.example/live?profile=2");
    assert_eq!(url.tls_server(), Some(("cam.example".to_owned(), 322)));
    assert_eq!(parsed("rtsps://[fe80::1]:8322/live").tls_server(), Some(("fe80::1".to_owned(), 8322)));
    assert_eq!(parsed("rtsp://cam.example/live").tls_server(), None);
    let reached = |url: &VideoUrl| {
        let VideoSource::Rtsp { address, .. } = &url.source else { panic!("it is RTSP") };
        url.reachable(address).map(String::from)
    };
    assert_eq!(reached(&url), None);
    let url = url.through(SocketAddr::from(([127, 0, 0, 1], 5004)));
    assert_eq!(reached(&url), Some("rtsp://127.0.0.1:5004/live?profile=2".to_owned()));
    assert_eq!(url.to_string(), "rtsps://***@cam.example/live?profile=2");
    assert_eq!(reached(&parsed("rtsp://cam.example/live")), Some("rtsp://cam.example/live".to_owned()));
}

#[test]
fn a_password_is_used_and_never_printed() {
    let url = parsed("rtsp://admin:s%40cret@cam.example/live");
    for text in [url.to_string(), format!("{url:?}"), format!("{:?}", url.source)] {
        assert!(!text.contains("cret") && !text.contains("admin"), "{text}");
    }
    let VideoSource::Rtsp { login: Some(login), address } = url.source else { panic!("it has a login") };
    assert_eq!((login.user.as_str(), login.password.as_str()), ("admin", "s@cret"));
    assert_eq!(address.as_str(), "rtsp://cam.example/live");
    assert!(!format!("{login:?}").contains("cret"));
    for text in ["rtmp://u:secret@h/x", "rtsp://u:secret@", "rtsp://u:sec/ret@h:x/"] {
        let error = VideoUrl::parse(text).unwrap_err();
        assert!(!format!("{error} {error:?}").contains("ret@"), "{error:?}");
    }
}

#[test]
fn a_login_given_beside_the_address_is_used_and_given_once() {
    let login = Login::parse("admin:s:cret").unwrap();
    let url = parsed("rtsp://cam.example/live").with_login(login.clone()).unwrap();
    assert_eq!(url.to_string(), "rtsp://***@cam.example/live");
    let VideoSource::Rtsp { login: Some(used), .. } = &url.source else { panic!("it has a login") };
    assert_eq!((used.user.as_str(), used.password.as_str()), ("admin", "s:cret"));
    for text in ["rtsp://root:other@cam.example/live", "clip.mp4"] {
        let error = parsed(text).with_login(login.clone()).unwrap_err().to_string();
        assert!(!error.contains("cret") && !error.contains("other"), "{error}");
    }
    for text in ["", "admin", ":secret"] {
        assert_eq!(Login::parse(text), Err(LoginError));
    }
}

#[test]
fn what_is_not_read_by_this_build_comes_with_a_remedy() {
    for (text, remedy) in [
        ("v4l2:///dev/video0", "ffmpeg -f v4l2 -i /dev/video0"),
        ("udp://127.0.0.1:5600", "MediaMTX"),
        ("https://cam.example/live.m3u8", "MediaMTX"),
        ("sim:arena1", "barrelman run --video sim:arena1"),
        ("gopher://cam.example/live", "rtsp://HOST/PATH"),
        ("clip.mp4?fps=0", "more than 0"),
        ("clip.mp4?fps=many", "?fps=30"),
        ("clip.mp4?fault=explode@1", "use stall"),
        ("rtsp:///live", "rtsp://HOST"),
        ("", "no video source"),
    ] {
        let error = VideoUrl::parse(text).unwrap_err().to_string();
        assert!(error.contains(remedy), "{text}: {error}");
    }
}

#[test]
fn what_is_printed_reads_as_the_same() {
    for text in ["clip.mp4", "frames?fps=12.5&fault=stall@1+2", "rtsp://cam.example/live?profile=2"] {
        assert_eq!(parsed(text).to_string(), text);
        assert!(parsed(&parsed(text).to_string()) == parsed(text));
    }
}
