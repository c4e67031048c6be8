//! The files of the page, embedded in the program.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse as _, Response};

use super::states;

macro_rules! files {
    ($($name:literal),+ $(,)?) => {
        /// Name and content of each file.
        pub(super) const FILES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!("../../../console/", $name)))),+];
    };
}

files![
    "access.js",
    "appearance.js",
    "clock.js",
    "control_seat.js",
    "controls.js",
    "decoder.js",
    "devices.css",
    "devices.js",
    "dialogs.js",
    "drills.css",
    "drills.js",
    "elements.js",
    "events.js",
    "facts.js",
    "gamepad.js",
    "geometry.js",
    "heartbeat.js",
    "held.js",
    "held_controls.js",
    "help.css",
    "help.js",
    "help_place.js",
    "hints.css",
    "hints.js",
    "index.html",
    "key_box.js",
    "keys.js",
    "layers.js",
    "layout.css",
    "library.css",
    "library.html",
    "library.js",
    "link.js",
    "main.js",
    "map_tiles.js",
    "marks.js",
    "narrow.css",
    "new_drive.css",
    "new_drive.js",
    "next_action.js",
    "nudge_obstacle.js",
    "numbers.js",
    "overlay.js",
    "pick.css",
    "pick.html",
    "pick.js",
    "picture_notice.js",
    "player.js",
    "snapshot_history.js",
    "sounds.js",
    "stage.js",
    "status.js",
    "stop.js",
    "strips.js",
    "style.css",
    "two_videos.js",
    "video.js",
    "video_message.js",
    "wake_lock.js",
    "words.en.js",
    "words.js",
];

fn content(name: &str) -> Option<&'static str> {
    if name == states::NAME {
        return Some(states::MODULE.as_str());
    }
    FILES.iter().find(|(own, _)| *own == name).map(|(_, content)| *content)
}

/// The answer with a file of the page.
pub(super) fn response(name: &str) -> Response {
    match content(name) {
        Some(content) => ([(header::CONTENT_TYPE, content_type(name))], content).into_response(),
        None => (StatusCode::NOT_FOUND, "there is no such file\n").into_response(),
    }
}

fn content_type(name: &str) -> &'static str {
    match name.rsplit_once('.').map(|(_, ending)| ending) {
        Some("html") => "text/html; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("svg") => "image/svg+xml",
        _ => "text/plain; charset=utf-8",
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;

    fn content(name: &str) -> &'static str {
        super::content(name).unwrap_or_else(|| panic!("{name} is not served"))
    }

    /// What stands between `before` and the next `after` in a text, each time.
    fn all_between<'a>(text: &'a str, before: &'a str, after: char) -> impl Iterator<Item = &'a str> {
        text.split(before).skip(1).filter_map(move |rest| rest.split(after).next())
    }

    #[test]
    fn every_file_of_the_folder_is_served() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../console");
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
        let files = entries.filter(|entry| entry.file_type().unwrap().is_file());
        let found: BTreeSet<String> = files.map(|entry| entry.file_name().into_string().unwrap()).collect();
        let served = FILES.iter().map(|(name, _)| *name);
        assert_eq!(found, served.chain(["README.md"]).map(str::to_owned).collect());
    }

    #[test]
    fn everything_that_the_page_loads_is_served() {
        let page = content("index.html");
        let mut loaded: Vec<&str> = all_between(page, "=\"/console/", '"').collect();
        for (_, script) in FILES.iter().filter(|(name, _)| name.ends_with(".js")) {
            loaded.extend(all_between(script, "from \"./", '"'));
            loaded.extend(all_between(script, "import(\"/console/", '"'));
        }
        assert!(loaded.len() > 20, "{loaded:?}");
        for name in loaded {
            content(name);
        }
    }

    #[test]
    fn the_page_obeys_its_content_security_policy() {
        let page = content("index.html");
        for tag in all_between(page, "<", '>') {
            let attributes = tag.split_whitespace().skip(1);
            for name in attributes.map(|attribute| attribute.split('=').next().unwrap_or_default()) {
                assert!(name != "style" && !name.starts_with("on"), "{name} in <{tag}>");
            }
            assert!(!tag.starts_with("style") && !tag.starts_with("iframe"), "<{tag}>");
            assert!(!tag.starts_with("script") || tag.contains(" src=\"/console/"), "<{tag}>");
        }
        for (name, text) in FILES {
            for word in ["eval(", "new Function", "innerHTML", "document.write", "setAttribute(\"style\""] {
                assert!(!text.contains(word), "{word} in {name}");
            }
            for start in ["http://", "https://", "ws://", "wss://"] {
                assert!(!text.contains(&format!("\"{start}")), "a foreign address in {name}");
            }
        }
    }

    #[test]
    fn a_file_has_the_content_type_of_its_ending() {
        for (name, kind) in [
            ("a.html", "text/html; charset=utf-8"),
            ("a.css", "text/css; charset=utf-8"),
            ("a.en.js", "text/javascript; charset=utf-8"),
            ("a.svg", "image/svg+xml"),
            ("a.json", "text/plain; charset=utf-8"),
            ("html", "text/plain; charset=utf-8"),
        ] {
            assert_eq!(content_type(name), kind, "{name}");
        }
    }
}
