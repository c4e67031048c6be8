//! The build profiles of the released program and of the program for debugging.

use toml::Value;

#[test]
fn the_released_program_has_no_line_tables_and_the_one_for_debugging_has() {
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/../../Cargo.toml");
    let manifest: toml::Table = std::fs::read_to_string(manifest).unwrap().parse().unwrap();
    let profile = |name: &str| manifest["profile"][name].clone();
    let released = profile("release");
    assert_eq!(released["debug"], Value::from(false));
    assert_eq!(released["strip"], Value::from("debuginfo"));
    let debugged = profile("release-debug");
    assert_eq!(debugged["inherits"], Value::from("release"));
    assert_eq!(debugged["debug"], Value::from("line-tables-only"));
    assert_eq!(debugged["strip"], Value::from("none"));
}
