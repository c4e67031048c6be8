use barrelman_media_protocol::format::CodedFormat;
use barrelman_media_protocol::source::{DeviceFormat, DeviceSettings};
use barrelman_vocab::PictureSize;

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
    let shown = parsed("rtsp://cam.example/user=admin&password=secret&channel=1").to_string();
    assert_eq!(shown, "rtsp://cam.example/user=admin&password=***&channel=1");
    // The frame rate is the camera's affair.
    let VideoSource::Rtsp { address, login: None, .. } = url.source else { panic!("it is RTSP") };
    assert_eq!(address.as_str(), "rtsp://cam.example:8554/live?profile=2&fps=9");
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
    let VideoSource::Rtsp { login: Some(login), address, .. } = url.source else { panic!("it has a login") };
    assert_eq!((login.user.as_str(), login.password.as_str()), ("admin", "s@cret"));
    assert_eq!(address.as_str(), "rtsp://cam.example/live");
    assert!(!format!("{login:?}").contains("cret"));
    for text in ["rtmp://u:secret@h/x", "https://u:secret@h/x.m3u8"] {
        let url = parsed(text);
        let printed = format!("{url} {url:?} {:?}", url.source);
        assert!(printed.contains("://***@h/x") && !printed.contains("secret"), "{printed}");
    }
    for text in ["rtsp://u:secret@", "rtsp://u:sec/ret@h:x/", "udp://u:secret@h:1"] {
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
fn what_cannot_be_an_address_comes_with_a_remedy() {
    for (text, remedy) in [
        ("sim:arena1", "barrelman run --video sim:arena1"),
        ("gopher://cam.example/live", "rtsp://HOST/PATH"),
        ("cam.example:554/live", "write rtsp://cam.example:554/live"),
        ("192.168.0.7:8554", "write rtsp://192.168.0.7:8554"),
        ("clip.mp4?fps=0", "more than 0"),
        ("clip.mp4?fps=many", "fps=30"),
        ("clip.mp4?fault=explode@1", "use stall"),
        ("rtsp:///live", "rtsp://HOST"),
        ("rtsp://h/live?transport=pigeon", "transport=udp"),
        ("udp://0.0.0.0", "there is no port"),
        ("udp://cam.example:5600", "in numbers"),
        ("udp://:5600?codec=vp8", "codec=h265"),
        ("udp://:5600?codec=h264&x=1", "x=1 is no option"),
        ("/dev/video0?size=big", "size=1280x720"),
        ("/dev/video0?speed=9", "an option is unknown"),
        ("gst:", "gst:videotestsrc"),
        ("", "no video source"),
    ] {
        let error = VideoUrl::parse(text).unwrap_err().to_string();
        assert!(error.contains(remedy), "{text}: {error}");
    }
}

fn check_media(text: &str, shown: &str, address: &SourceAddress) {
    let url = parsed(text);
    assert_eq!(url.to_string(), shown, "{text}");
    let VideoSource::Media(source) = url.source else { panic!("{text} is read by GStreamer") };
    assert!(source.address == *address, "{text}");
}

#[test]
fn addresses_of_gstreamer_are_told_apart() {
    let udp = |bind: &str, format| SourceAddress::Udp { bind: bind.parse().unwrap(), format };
    let h265 = Some(CodedFormat::H265);
    check_media("udp://:5600", "udp://0.0.0.0:5600", &udp("0.0.0.0:5600", None));
    check_media("rtp://239.1.2.3:5004", "udp://239.1.2.3:5004", &udp("239.1.2.3:5004", None));
    check_media("udp://[::]:5600?codec=h265", "udp://[::]:5600", &udp("[::]:5600", h265));
    check_media("UDP://127.0.0.1:5600", "udp://127.0.0.1:5600", &udp("127.0.0.1:5600", None));
    check_media("camera.sdp", "camera.sdp", &SourceAddress::Sdp("camera.sdp".into()));
    let device = |path: &str| DeviceSettings { path: path.into(), size: None, fps: None, format: None };
    check_media("/dev/video7", "/dev/video7", &SourceAddress::Device(device("/dev/video7")));
    let settings = DeviceSettings {
        size: Some(PictureSize::new(1280, 720)),
        fps: Some(30.0),
        format: Some(DeviceFormat::Mjpeg),
        ..device("/dev/video0")
    };
    let text = "v4l2:/dev/video0?size=1280x720&fps=30&format=mjpeg";
    check_media(text, "/dev/video0", &SourceAddress::Device(settings));
    let pipeline = "videotestsrc ! x264enc";
    check_media(
        "gst:videotestsrc ! x264enc",
        "gst:videotestsrc ! x264enc",
        &SourceAddress::Pipeline(pipeline.into()),
    );
    let login = SourceLogin { user: "u".into(), password: "p".into(), permits_basic: false };
    let network = SourceAddress::Network { url: "http://cam.example/video?x=1".into(), login: Some(login) };
    check_media("http://u:p@cam.example/video?x=1", "http://***@cam.example/video?x=1", &network);
    let network = SourceAddress::Network { url: "srt://cam.example:9?passphrase=secret".into(), login: None };
    check_media("srt://cam.example:9?passphrase=secret", "srt://cam.example:9?passphrase=***", &network);
}

/// A link in the folder of temporary files, as long as the value lives.
struct Link(std::path::PathBuf);

impl Link {
    fn to(target: &str) -> Self {
        let name = format!("barrelman-{}-{}", std::process::id(), target.replace('/', "-"));
        let link = std::env::temp_dir().join(name);
        std::os::unix::fs::symlink(target, &link).unwrap();
        Self(link)
    }
}

impl Drop for Link {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

#[test]
fn a_link_to_a_capture_device_is_one() {
    let link = Link::to("/dev/video61");
    let by_id = "/dev/v4l/by-id/usb-Camera_0001-video-index0";
    for path in [link.0.to_str().unwrap(), by_id] {
        let settings = DeviceSettings { path: path.into(), size: None, fps: None, format: None };
        check_media(path, path, &SourceAddress::Device(settings.clone()));
        let (size, fps) = (Some(PictureSize::new(1280, 720)), Some(30.0));
        let address = SourceAddress::Device(DeviceSettings { size, fps, ..settings });
        check_media(&format!("{path}?size=1280x720&fps=30"), path, &address);
    }
}

#[test]
fn a_device_that_is_no_camera_is_told() {
    let link = Link::to("/dev/null");
    for path in ["/dev/null", link.0.to_str().unwrap()] {
        let error = VideoUrl::parse(path).unwrap_err().to_string();
        assert!(error.contains("neither a camera nor a pipe"), "{error}");
        assert!(error.contains(&format!("v4l2:{path}")), "{error}");
    }
}

#[test]
fn what_is_printed_reads_as_the_same() {
    for text in ["clip.mp4", "frames?fps=12.5&fault=stall@1+2", "rtsp://cam.example/live?profile=2"] {
        assert_eq!(parsed(text).to_string(), text);
        assert!(parsed(&parsed(text).to_string()) == parsed(text));
    }
}
