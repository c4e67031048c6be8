//! The built-in scenarios, and the messages for mistakes in a scenario file.

use barrelman_experiments::scenario::file::ScenarioFile;
use barrelman_experiments::scenario::{BUILT_IN, ScenarioOverrides, complete, load, resolve};
use barrelman_sim::World;
use barrelman_sim::scenario::{BeyondBorder, Platform};
use barrelman_sim::snapshot::ObjectKind;
use barrelman_vocab::PictureSize;

/// The text of a built-in scenario.
fn text(name: &str) -> String {
    BUILT_IN.iter().find(|built_in| built_in.name == name).map(|built_in| built_in.text.to_owned()).unwrap()
}

/// The message for a scenario's text with a mistake.
fn message_for(text: &str) -> String {
    let mistake = resolve::read(text, &ScenarioOverrides::default()).unwrap_err();
    mistake.located_in("mine.toml", text).to_string()
}

#[test]
fn every_built_in_scenario_can_be_loaded_in_all_its_settings() {
    for built_in in BUILT_IN {
        let loaded = load(built_in.name, &ScenarioOverrides::default()).unwrap();
        assert_eq!(loaded.scenario.name, built_in.name);
    }
    for (name, setting) in
        [("lab1", "still"), ("lab2", "windy"), ("field1", "still"), ("arena1", "calm"), ("open", "tether")]
    {
        let overrides =
            ScenarioOverrides { setting: Some(setting.to_owned()), ..ScenarioOverrides::default() };
        assert_eq!(load(name, &overrides).unwrap().setting, setting);
    }
}

#[test]
fn the_laboratory_has_the_plant_and_the_optics_as_identified() {
    // The intervals that were identified from the recorded trials; dead times are less the camera's 0.1 s.
    for name in ["lab1", "lab2", "field1", "field2", "steep1", "steep2"] {
        let scenario = load(name, &ScenarioOverrides::default()).unwrap().scenario;
        let within = |what: &str, value: f64, low: f64, high: f64| {
            assert!((low..=high).contains(&value), "{name}: {what} {value}, {low} to {high}");
        };
        let (pan, tilt) = (scenario.mount.pan, scenario.mount.tilt);
        within("focal length", scenario.camera.optics.focal_px, 305.0, 350.0);
        within("pan start", pan.start_dead_time_s + 0.1, 0.25, 0.35);
        within("pan stop", pan.stop_dead_time_s + 0.1, 0.44, 0.61);
        within("pan lag", pan.lag_s, 0.35, 0.45);
        within("tilt start", tilt.start_dead_time_s + 0.1, 0.10, 0.25);
        within("tilt stop", tilt.stop_dead_time_s + 0.1, 0.40, 0.60);
        within("tilt lag", tilt.lag_s, 0.0, 0.2);
        assert_eq!(scenario.camera.frame, PictureSize::new(640, 480), "{name}");
        assert_eq!(scenario.camera.optics.picture, PictureSize::new(640, 360), "{name}");
        assert_eq!(scenario.camera.pictures_per_second, 30, "{name}");
        assert_eq!(pan.imperfections, Default::default(), "{name}: no flaws were identified");
        let clamped = BeyondBorder::Clamped { x_px: 316.0, y_px: 177.0 };
        let expected = if name.starts_with("lab") { clamped } else { BeyondBorder::Absent };
        assert_eq!(scenario.sensing.beyond_border, expected, "{name}");
    }
    let indoor = load("lab1", &ScenarioOverrides::default()).unwrap().scenario;
    let Platform::Swaying(sway) = indoor.platform else { panic!("it sways") };
    assert!(
        (sway.yaw.std_dev.to_degrees() - 0.3).abs() < 1e-9 && sway.yaw.time_constant_s == 1.5,
        "{sway:?}"
    );
    assert_eq!(
        (indoor.camera.height_m, indoor.sensing.noise.std_dev, indoor.sensing.is_rounded),
        (1.83, 0.6, true)
    );
}

#[test]
fn another_size_shows_the_same_view() {
    let overrides =
        ScenarioOverrides { size: Some(PictureSize::new(320, 180)), ..ScenarioOverrides::default() };
    let small = load("lab1", &overrides).unwrap().scenario.camera;
    assert_eq!((small.optics.focal_px, small.frame), (165.0, PictureSize::new(320, 240)));
    let small = load("arena1", &overrides).unwrap().scenario.camera;
    assert_eq!((small.optics.focal_px, small.frame), (190.0, PictureSize::new(320, 180)));
}

#[test]
fn a_mistake_is_shown_with_its_line() {
    let check = |name: &str, old: &str, new: &str, line_holds: &str, words: &str| {
        let original = text(name);
        assert!(original.contains(old), "{name} has no {old}");
        let changed = original.replacen(old, new, 1);
        let number = changed.lines().position(|line| line.contains(line_holds)).unwrap() + 1;
        let message = message_for(&changed);
        assert!(message.contains(&format!("line {number}")), "{message}\nexpected line {number}");
        assert!(message.contains(words), "{message}\nexpected {words}");
    };
    check("arena1", "sea_state = 1", "sea_state = 7", "sea_state = 7", "0 (glassy) to 4 (moderate)");
    check("lab1", "height_m = 1.83", "height_m = -3", "height_m = -3", "metres from 0.2 to 500");
    check("lab1", "scale = 0.616", "scale = 900", "path = \"arena1\"", "leaves the world");
    check("lab1", "pictures_per_second = 30", "pictures_per_second = 7", "= 7", "120 can be divided by");
    check("lab1", "path = \"arena1\"", "path = \"arena9\"", "arena9", "arena1, arena2");
    check("lab1", "start_dead_time_s = 0.30", "start_dead_time_s = 0.05", "= 0.05", "camera.latency_s");
    check(
        "distractors",
        "kind = \"buoy\"",
        "kind = \"buoy\"\njitter_m = -4",
        "jitter_m = -4",
        "object.4.jitter_m",
    );
    check("lab1", "noise_px = 0.6", "noise = 0.6", "noise = 0.6", "there is no key `noise`");
    check("open", "[kite.tether]", "[kite.other]", "setting = \"tether\"", "use one of calm, other");
}

#[test]
fn what_a_scenario_does_not_have_cannot_be_changed() {
    let overrides = ScenarioOverrides { sea_state: Some(2), ..ScenarioOverrides::default() };
    let error = format!("{:#}", load("lab1", &overrides).unwrap_err());
    assert!(error.contains("there is no water"), "{error}");
    let error = format!("{:#}", load("lab3", &ScenarioOverrides::default()).unwrap_err());
    assert!(error.contains("lab1, lab2, arena1") && error.contains(".toml"), "{error}");
}

#[test]
fn a_printed_scenario_is_the_built_in_one() {
    for built_in in BUILT_IN {
        let read = |text: &str| {
            let loaded = resolve::read(text, &ScenarioOverrides::default());
            loaded.unwrap_or_else(|error| panic!("{}", error.located_in(built_in.name, text))).scenario
        };
        let printed = complete(built_in.text);
        assert_eq!(read(&printed), read(built_in.text), "{}", built_in.name);
        assert_eq!(
            complete(&printed).matches("Additional scale of x").count(),
            printed.matches("Additional scale of x").count()
        );
    }
}

/// The keys that a section may have, from the parser's answer to a key that no section has.
fn keys_of_section(text: &str, header: &str) -> Vec<String> {
    let changed = text.replacen(header, &format!("{header}\nno_such_key = 1"), 1);
    let error = toml::from_str::<ScenarioFile>(&changed).unwrap_err();
    let message = error.message();
    let expected = message.split_once("expected").unwrap_or_else(|| panic!("{header}: {message}")).1;
    expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn a_printed_scenario_holds_every_key() {
    for built_in in BUILT_IN {
        let printed = complete(built_in.text);
        let headers: Vec<&str> =
            printed.lines().filter(|line| line.starts_with('[') && line.ends_with(']')).collect();
        assert!(headers.len() > 8, "{}: {headers:?}", built_in.name);
        let mut objects = 0;
        for header in headers {
            objects += usize::from(header == "[[object]]");
            if header == "[[object]]" && objects > 1 {
                continue;
            }
            let start = printed.find(&format!("\n{header}\n")).unwrap() + header.len() + 2;
            let end = printed[start..].find("\n[").map_or(printed.len(), |length| start + length);
            let section = &printed[start..end];
            for key in keys_of_section(&printed, header) {
                let is_there = section.lines().any(|line| {
                    line.trim_start_matches("# ").split(' ').next() == Some(key.as_str())
                        && line.contains('=')
                });
                // Sections within sections have headers of their own.
                let is_section = printed.contains(&format!("{}.{key}]", &header[..header.len() - 1]));
                assert!(is_there || is_section, "{}: {header} has no {key}\n{section}", built_in.name);
            }
        }
        for section in ["camera.loss", "water", "boat", "target", "object"] {
            assert!(printed.contains(&format!("[{section}]")), "{}: {section}", built_in.name);
        }
    }
}

#[test]
fn people_drift_with_the_current_and_the_other_objects_do_not() {
    let check = |name: &str, drifting: (f64, f64), tolerance: f64| {
        let scenario = load(name, &ScenarioOverrides::default()).unwrap().scenario;
        let mut world = World::new(&scenario, 3).unwrap();
        let (mut before, mut after) = (Vec::new(), Vec::new());
        world.write_objects(&mut before);
        for _ in 0..20 * 120 {
            world.advance();
        }
        world.write_objects(&mut after);
        for (from, to) in before.iter().zip(&after) {
            let (x, y) =
                (to.pose.position.x - from.pose.position.x, to.pose.position.y - from.pose.position.y);
            let expected = match to.kind {
                ObjectKind::Swimmer | ObjectKind::LifeJacket => (20.0 * drifting.0, 20.0 * drifting.1),
                _ => continue,
            };
            assert!(
                (x - expected.0).abs() < tolerance && (y - expected.1).abs() < tolerance,
                "{name}: {:?} drifted by {x}, {y}",
                to.kind
            );
        }
    };
    // The wind of sea state 1 adds 3 cm/s to the current, its waves 3 cm/s at most.
    check("rescue-current", (0.35, 0.0), 1.3);
    check("open", (0.0, 0.0), 1e-9);
}
