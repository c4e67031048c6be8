//! The configuration: the example, the JSON schema, defaults, and refused values.

use barrelman_experiments::law_choice::LawChoice;
use barrelman_experiments::tracker_choice::TrackerName;
use barrelman_station::cli::LawOptions;
use barrelman_station::config::{self, ConfigFile, Configuration};
use barrelman_vision::{FusedConfig, FusedSetting};
use barrelman_vocab::{Framed, LawId, LawName, OptimalMode};

fn resolved(text: &str) -> Result<Configuration, String> {
    let resolve = || -> anyhow::Result<Configuration> { Configuration::resolve(&config::parse(text)?) };
    resolve().map_err(|error| format!("{error:#}"))
}

#[track_caller]
fn refused(text: &str, part: &str) {
    match resolved(text) {
        Err(message) => assert!(message.contains(part), "{message}"),
        Ok(_) => panic!("accepted: {text}"),
    }
}

/// A calibrated lens.
const LENS: &str = "[camera.lens]\nwidth = 1280\nheight = 720\nfx = 760.1\nfy = 755\ncx = 640.7\ncy = 355.25\nk1 = -0.09\nk2 = 0.012\np1 = 0.0011\np2 = -0.0007\nk3 = -0.001\n";

/// The example without the marks of comments before its keys.
fn example_in_force() -> String {
    let example = config::example().expect("the defaults are usable");
    let is_key = |line: &str| toml::from_str::<toml::Table>(line).is_ok_and(|table| !table.is_empty());
    example
        .lines()
        .map(|line| line.strip_prefix("# ").filter(|rest| is_key(rest)).unwrap_or(line))
        .fold(String::new(), |text, line| text + line + "\n")
}

#[test]
fn the_committed_example_is_the_one_that_the_program_prints() {
    let committed = include_str!("../../../../config/barrelman.example.toml");
    assert_eq!(
        committed,
        config::example().unwrap(),
        "run: barrelman config example > config/barrelman.example.toml"
    );
}

#[test]
fn the_services_configuration_is_usable_once_it_has_a_video() {
    let text = include_str!("../../../../config/service/barrelman.toml");
    let resolved = |text: &str| Configuration::resolve(&config::parse(text).unwrap()).unwrap();
    assert_eq!(resolved(text).video, None);
    // Its proposals are usable, too.
    let proposed = resolved(&text.replace("# url", "url"));
    assert!(proposed.video.is_some() && proposed.link.is_some());
    let console = proposed.console;
    assert!(
        console.address.listen.is_some_and(|address| address.ip().is_loopback()),
        "the page is for this computer alone"
    );
    assert!(console.tokens.file.is_some_and(|file| file.starts_with("/var/lib/barrelman")));
    assert!(proposed.recording.folder.starts_with("/var/lib/barrelman"));
}

#[test]
fn the_example_changes_nothing_as_it_stands() {
    let example = resolved(&config::example().unwrap()).expect("the example is usable");
    assert_eq!(example, Configuration::resolve(&ConfigFile::default()).expect("the defaults are usable"));
}

#[test]
fn every_key_of_the_example_can_be_read() {
    let text = example_in_force();
    config::parse(&text).unwrap_or_else(|error| panic!("{error:#}\n{text}"));
}

#[test]
fn the_example_shows_the_value_that_holds() {
    let shown: toml::Table = toml::from_str(&example_in_force()).unwrap();
    let effective = Configuration::resolve(&ConfigFile::default()).unwrap().to_file();
    let effective = toml::Table::try_from(effective).unwrap();
    let mut compared = 0;
    for (section, keys) in &effective {
        for (key, value) in keys.as_table().unwrap() {
            assert_eq!(&shown[section][key], value, "{section}.{key}");
            compared += 1;
        }
    }
    assert!(compared > 30, "{compared}");
}

#[test]
fn the_effective_configuration_reads_back_as_itself() {
    let changed = resolved(
        "[vehicle]\nregion_half_width = 0.4\nyaw_sign = \"same\"\n[tracker]\nname = \"camshift\"\nvalue_floor = 7\n[tracker.fused]\ncoast_s = 0.7\nconfirm = 9\n",
    );
    let changed = changed.expect("it is usable");
    assert_eq!(resolved(&changed.to_toml().unwrap()), Ok(changed));
    let calibrated = resolved(LENS).expect("it is usable");
    assert!(calibrated.profile.camera.lens.is_some());
    assert_eq!(calibrated.profile.camera.focal_share, 760.1 / 1280.0);
    assert_eq!(resolved(&calibrated.to_toml().unwrap()), Ok(calibrated));
}

#[test]
fn the_committed_schema_is_the_one_that_the_program_prints() {
    let committed = include_str!("../../../../config/barrelman.schema.json");
    assert_eq!(
        committed.trim(),
        config::schema().unwrap().trim(),
        "run: barrelman config schema > config/barrelman.schema.json"
    );
}

#[test]
fn every_key_of_the_schema_stands_in_the_example_with_its_range() {
    let schema: serde_json::Value = serde_json::from_str(&config::schema().unwrap()).unwrap();
    let example = config::example().unwrap();
    let mut ranges = 0;
    for (section, keys) in schema["$defs"].as_object().unwrap() {
        for (key, declared) in keys["properties"].as_object().into_iter().flatten() {
            let is_section = declared.get("$ref").is_some() || declared.get("anyOf").is_some();
            let stands = example.contains(&format!("# {key} = ")) || example.contains(&format!("{key}]"));
            assert!(stands, "{section}: {key} is not in the example");
            assert!(is_section || declared["description"].is_string(), "{section}: {key} has no words");
            ranges += u32::from(declared["maximum"].is_number());
        }
    }
    assert!(ranges >= 50, "{ranges} keys have a range");
    let fused = schema["$defs"]["FusedSection"]["properties"].as_object().unwrap();
    assert_eq!(fused.len(), FusedConfig::SETTINGS.len());
    for FusedSetting { name, min, max, .. } in FusedConfig::SETTINGS {
        let declared = &fused[*name];
        assert_eq!(
            (declared["minimum"].as_f64(), declared["maximum"].as_f64()),
            (Some(*min), Some(*max)),
            "{name}"
        );
    }
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_place() {
    refused("[vehicle]\nregoin_half_width = 0.5\n", "regoin_half_width");
    refused("[vehicle]\nregion_half_width = \"wide\"\n", "line 2");
    refused("[vehicle]\nregion_half_width = \"wide\"\n", "expected a number, found the text \"wide\"");
    refused("video = 3\n", "expected a section of keys");
    refused("[tracker]\nname = \"csrt\"\n", "csrt");
    refused(
        "[vehicle]\nregion_half_width = 1.5\n",
        "vehicle.region_half_width = 1.5: use a share from 0.01 to 1",
    );
    refused("[vehicle]\nregion_half_width = nan\n", "region_half_width");
    refused("[vehicle]\nprofile = \"kite\"\n", "use one of fotokite-pro");
    refused(
        "[vehicle]\nschema_pan_rad_per_s = 2.0\n",
        "vehicle.schema_pan_rad_per_s = 2: use rad/s from 0 to 0.4, vehicle.limit_pan_rad_per_s",
    );
    refused(
        "[vehicle]\nlimit_tilt_rad_per_s = 0.2\n",
        "vehicle.schema_tilt_rad_per_s = 0.3: use rad/s from 0 to 0.2, vehicle.limit_tilt_rad_per_s",
    );
    refused(
        "[vehicle]\nlimit_pan_rad_per_s = 3.0\n",
        "vehicle.limit_pan_rad_per_s = 3: use rad/s from 0 to 0.4, the limit of the vehicle",
    );
    refused(
        "[vehicle]\nlimit_tilt_rad_per_s = 0.31\n",
        "vehicle.limit_tilt_rad_per_s = 0.31: use rad/s from 0 to 0.3",
    );
    refused("[vehicle]\ncoast_motion_s = -1.0\n", "coast_motion_s = -1");
    refused("[vehicle]\ncoast_motion_s = 0.6\n", "coast_motion_s = 0.6: use seconds from 0.05 to 0.5");
    refused("[vehicle]\ncoast_motion_s = 0\n", "coast_motion_s = 0: use seconds from 0.05 to 0.5");
    refused(
        "[camera]\nfocal_share = 0\n",
        "camera.focal_share = 0: use a share of the picture's width from 0.1 to 20",
    );
    // A boat's values are checked without a boat, too.
    refused("[vessel]\nkeep_out_m = 900.0\n", "vessel.keep_out_m = 900: use metres from 0.5 to 50");
    refused("[vessel]\nthrottle_ahead = 1.1\n", "vessel.throttle_ahead = 1.1: use a share from 0 to 1");
    refused(
        "[vessel]\nkeep_way_throttle = 0.4\n",
        "vessel.keep_way_throttle = 0.4: use a share from 0 to 0.3",
    );
    refused("[vessel]\nkeep_way_s = 2\n", "vessel.keep_way_s has no effect without vessel.keep_way_throttle");
    for (section, url, wanted) in
        [("link", "http://kite/api", "https:// or onvifs://"), ("video", "rtsp://kite/live", "rtsps://")]
    {
        let text = format!("[{section}]\nurl = \"{url}\"\nca_file = \"ca.pem\"\n");
        refused(&text, &format!("{section}.ca_file is about {wanted}, and {section}.url is not encrypted"));
    }
    refused("[vessel]\nkeep_way_s = 4\n", "vessel.keep_way_s = 4: use seconds from 0.1 to 3");
    refused("[vessel]\nstand_off_m = 0\n", "vessel.stand_off_m = 0: use metres from 0.5 to 50");
    refused("[vessel]\nvehicle_system = 0\n", "vessel.vehicle_system = 0: use 1 to 255");
    refused("[link]\nsystem_id = 0\n", "link.system_id = 0: use 1 to 255");
    refused("[tracking_camera]\ncomponent_id = 0\n", "tracking_camera.component_id = 0: use 1 to 255");
    refused("[vessel]\nprofile = \"jett\"\n", "there is no vessel profile \"jett\"");
    refused("[camera]\nlowest_tilt_rad = 0.4\n", "camera.lowest_tilt_rad is not below");
    refused("[camera.pan]\nlag_s = nan\n", "camera.pan.lag_s = NaN: use seconds from 0 to 2");
    refused("[camera.tilt]\nstop_dead_time_s = 0.05\n", "camera.tilt.stop_dead_time_s is less than");
    refused(
        "[camera.tilt]\nleast_rad_per_s = 0.35\n",
        "camera.tilt.least_rad_per_s = 0.35 is above vehicle.limit_tilt_rad_per_s = 0.3",
    );
    refused(
        "[vehicle]\nlimit_pan_rad_per_s = 0.3\n[camera.pan]\nleast_rad_per_s = 0.1\ngain = 0.3\n",
        "camera.pan.least_rad_per_s = 0.1 is above what the axis reaches",
    );
    refused(
        "[camera.pan]\nleast_rad_per_s = 0.25\n",
        "camera.pan.least_rad_per_s = 0.25: use rad/s from 0 to 0.2",
    );
    let lens = |from: &str, to: &str| LENS.replace(from, to);
    refused(&lens("fx = 760.1", "fx = -760.1"), "camera.lens.fx = -760.1: use pixels from 128 to 25600");
    refused(&lens("fx = 760.1", ""), "a key is missing: `fx`");
    refused(&lens("cx = 640.7", "cx = 1300"), "cx = 1300, cy = 355.25 is outside of the 1280x720 picture");
    refused(&lens("cy = 355.25", "cy = nan"), "is not a finite number");
    refused(&lens("k1 = -0.09", "k1 = inf"), "is not a finite number");
    refused(
        &lens("k1 = -0.09", "k1 = -0.9"),
        "the distortion folds over inside of the picture, at pixel 0, 0",
    );
    refused(&lens("k3 = -0.001", "k4 = 0.1"), "k4");
    refused(&lens("width = 1280", "width = 0"), "camera.lens.width = 0: use pixels from 16 to 32768");
    refused(&format!("[camera]\nfocal_share = 0.5\n{LENS}"), "omit camera.focal_share");
    refused("[camera]\nlens_file = \"lens.toml\"\n", "was not read");
    refused("[law]\nname = \"schema\"\nmode = \"eco\"\n", "law.mode is for the law \"optimal\" alone");
    refused("[law]\nname = \"optimal\"\nhorizon_s = 9\n", "law.horizon_s = 9: use seconds from 0.5 to 5");
    refused("[link]\nline_ending = \"crlf\"\n", "cr-around");
    refused("[tracker]\nvalue_floor = 300\n", "300");
    refused("[tracker]\nname = \"csrt\"\n", "`fused` or `camshift`");
    refused("[tracker.fusd]\ncoast_s = 0.4\n", "fusd");
    refused("[tracker.fused]\ncoast = 0.4\n", "coast_s");
    refused("[tracker.fused]\ncoast_s = 3.0\n", "tracker.fused.coast_s = 3: use seconds from 0 to 2");
    refused("[tracker.fused]\nconfirm = -1\n", "line 2");
    refused("[tracker.fused]\nconfirm = 21\n", "tracker.fused.confirm = 21: use 0 to 20");
    refused("[tracker.fused]\npadding = nan\n", "tracker.fused.padding = NaN: use 2.5 to 6");
    refused("[tracker.fused]\nlearning_rate = 0\n", "tracker.fused.learning_rate = 0: use 0.001 to 0.5");
    // Settings of the unused tracker are checked, too.
    refused("[tracker]\nname = \"camshift\"\n[tracker.fused]\nagility = 0\n", "tracker.fused.agility = 0");
    refused(
        "[tak]\naddress = \"239.2.3.1:6969\"\n",
        "--tak, or tak.address: \"239.2.3.1:6969\" is no address",
    );
    refused(
        "[share]\naddress = \"rtsp://0.0.0.0:8554\"\n",
        "--share, or share.address: \"rtsp://0.0.0.0:8554\" names no path",
    );
    for callsign in ["", " R1", "R\\n1", "R\\u0007", "R\\uFFFE", &"R".repeat(33)] {
        refused(&format!("[tak]\ncallsign = \"{callsign}\"\n"), "use 1 to 32 characters in one line");
    }
    refused("[nonsense]\n", "nonsense");
}

#[test]
fn the_fused_tracker_is_used_unless_another_is_named() {
    assert_eq!(resolved("").unwrap().tracker.name, TrackerName::Fused);
    assert_eq!(resolved("[tracker]\nname = \"camshift\"\n").unwrap().tracker.name, TrackerName::Camshift);
    // Settings of a tracker do not choose it.
    assert_eq!(resolved("[tracker]\nvalue_floor = 7\n").unwrap().tracker.name, TrackerName::Fused);
}

#[test]
fn an_effective_configuration_names_its_tracker() {
    for name in [TrackerName::Fused, TrackerName::Camshift] {
        let effective = resolved(&format!("[tracker]\nname = \"{}\"\n", name.as_str())).unwrap();
        assert_eq!(resolved(&effective.to_toml().unwrap()).unwrap().tracker.name, name);
    }
}

#[test]
fn the_optimal_law_is_used_unless_another_is_named() {
    assert_eq!(resolved("").unwrap().law, LawChoice::OPTIMAL);
    assert_eq!(resolved("[law]\nname = \"schema\"\n").unwrap().law, LawChoice::MOTOR_SCHEMA);
    let eco = resolved("[law]\nmode = \"eco\"\n").unwrap();
    assert_eq!(eco.law, LawChoice::of(LawId::Eco));
    assert_eq!(resolved(&eco.to_toml().unwrap()).unwrap().law, eco.law);
    let both = resolved("[law]\nframe = \"both\"\n").unwrap();
    assert_eq!(both.law, LawChoice { framed: Framed::Both, ..LawChoice::OPTIMAL });
    assert_eq!(resolved(&both.to_toml().unwrap()).unwrap().law, both.law);
    refused("[law]\nname = \"schema\"\nframe = \"both\"\n", "law.frame is for the law");
}

#[test]
fn the_command_line_says_otherwise_than_the_configuration_about_the_law() {
    let eco = LawChoice::of(LawId::Eco);
    let chosen = |law, mode, horizon| {
        LawOptions { law, mode, horizon, frame: None }.resolve(eco).map_err(|error| error.to_string())
    };
    assert_eq!(chosen(None, None, None), Ok(eco));
    assert_eq!(chosen(None, None, Some(2.0)), Ok(LawChoice { horizon_s: Some(2.0), ..eco }));
    assert_eq!(chosen(Some(LawName::Optimal), None, None), Ok(eco));
    assert_eq!(
        chosen(Some(LawName::Schema), None, None),
        Ok(LawChoice::MOTOR_SCHEMA),
        "the mode is dropped with the law"
    );
    assert!(
        chosen(Some(LawName::Schema), Some(OptimalMode::Eco), None).unwrap_err().contains("--mode is for")
    );
    assert!(chosen(None, None, Some(9.0)).unwrap_err().contains("--horizon = 9"));
    let both = LawOptions { frame: Some(Framed::Both), ..LawOptions::default() };
    assert_eq!(both.resolve(eco).unwrap(), LawChoice { framed: Framed::Both, ..eco });
    let schema = LawOptions { law: Some(LawName::Schema), ..both }.resolve(eco).unwrap_err();
    assert!(schema.to_string().contains("--frame is for the law"), "{schema}");
}

#[test]
fn two_cameras_of_one_component_are_refused() {
    let zooming = "[vehicle]\nprofile = \"mavlink-gimbal\"\n[camera.zoom]\nratio = 4.0\n";
    let tracking = "[tracking_camera]\nurl = \"udp://127.0.0.1:14550\"\n";
    refused(&format!("{zooming}{tracking}"), "set tracking_camera.component_id = 101");
    assert!(resolved(&format!("{zooming}{tracking}component_id = 101\n")).is_ok());
    assert!(resolved(&format!("{tracking}[vehicle]\nprofile = \"mavlink-gimbal\"\n")).is_ok());
}
