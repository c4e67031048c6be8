//! The configuration: the example, the schema, and what is refused.

use barrelman_station::config::{self, ConfigFile, Configuration};

fn resolved(text: &str) -> Result<Configuration, String> {
    let resolve = || -> anyhow::Result<Configuration> { Configuration::resolve(&config::parse(text)?) };
    resolve().map_err(|error| format!("{error:#}"))
}

#[track_caller]
fn refused(text: &str, part: &str) {
    match resolved(text) {
        Err(message) => assert!(message.contains(part), "{message}"),
        Ok(_) => panic!("taken: {text}"),
    }
}

#[test]
fn the_example_says_what_the_defaults_are() {
    let example = resolved(config::EXAMPLE).expect("the example is usable");
    assert_eq!(example, Configuration::resolve(&ConfigFile::default()).expect("the defaults are usable"));
}

#[test]
fn the_effective_configuration_reads_back_as_itself() {
    let changed =
        resolved("[vehicle]\nregion_half_width = 0.4\nyaw_sign = \"same\"\n[tracker]\nvalue_floor = 7\n");
    let changed = changed.expect("it is usable");
    assert_eq!(resolved(&changed.to_toml().unwrap()), Ok(changed));
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
fn every_key_of_the_schema_stands_in_the_example() {
    let file = Configuration::resolve(&ConfigFile::default()).unwrap().to_file();
    let effective = toml::to_string(&file).unwrap();
    for key in effective.lines().filter_map(|line| line.split_once(" = ").map(|(key, _)| key)) {
        assert!(config::EXAMPLE.contains(&format!("{key} = ")), "{key} is not in the example");
    }
}

#[test]
fn what_cannot_be_meant_is_refused_with_its_place() {
    refused("[vehicle]\nregoin_half_width = 0.5\n", "regoin_half_width");
    refused("[vehicle]\nregion_half_width = \"wide\"\n", "line 2");
    refused(
        "[vehicle]\nregion_half_width = 1.5\n",
        "vehicle.region_half_width = 1.5: use a share from 0.01 to 1",
    );
    refused("[vehicle]\nregion_half_width = nan\n", "region_half_width");
    refused("[vehicle]\nprofile = \"kite\"\n", "use one of fotokite-pro");
    refused("[vehicle]\nschema_pan_rad_per_s = 2.0\n", "above the limit of its axis");
    refused("[vehicle]\ncoast_motion_s = -1.0\n", "coast_motion_s = -1");
    refused("[link]\nline_ending = \"crlf\"\n", "cr-around");
    refused("[tracker]\nvalue_floor = 300\n", "300");
    refused("[nonsense]\n", "nonsense");
}
