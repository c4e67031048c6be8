//! Recorded positions through the law.

use barrelman_control::LawSettings;
use barrelman_trial::law::run_open_loop;
use barrelman_trial::logs::{laboratory, read_text};
use barrelman_vocab::{ImagePoint, VehicleProfile, VehicleRates};

use crate::trial_logs::rates;

#[test]
fn the_law_sees_positions_only() {
    // In 640x480: a = 192, b = 120.
    let rows = "10,10,{},1\n250,20,{},1\n-250,20,{},1\n20,130,{},1\n20,-130,{},1\n0,120,{},1\n";
    let with = |columns: &str| format!("{}{}", laboratory::HEADER, rows.replace("{}", columns));
    let profile = VehicleProfile::fotokite_pro();
    let law = |text: &str| {
        let log = read_text(text).unwrap().log;
        run_open_loop(&log, log.region(profile.region), &profile, LawSettings::MotorSchema)
    };
    let found = law(&with("0,0,0"));
    let asked: Vec<VehicleRates> = found.iter().map(|row| row.rates).collect();
    let rest = VehicleRates::REST;
    assert_eq!(asked, [rest, rates(-0.3, 0.0), rates(0.3, 0.0), rates(0.0, -0.3), rates(0.0, 0.3), rest]);
    assert_eq!(found, law(&with(",,")));
    assert_eq!(found, law(&with("0.1,-0.2,99")));
    assert_eq!(found[5].target, Some((ImagePoint { x: 0.0, y: 120.0 }, 1.0)));
    assert_eq!((found[5].row, found[5].time_s), (5, 5.0 / 37.23));
}

#[test]
fn the_law_asks_for_nothing_while_the_target_is_lost() {
    let text = "time_s,x,y,pitch_rate,yaw_rate\n0,250,0,0,0\n1,,,0,0\n";
    let (log, profile) = (read_text(text).unwrap().log, VehicleProfile::fotokite_pro());
    let found = run_open_loop(&log, log.region(profile.region), &profile, LawSettings::MotorSchema);
    assert_eq!((found[0].rates, found[1].rates), (rates(-0.3, 0.0), VehicleRates::REST));
    assert_eq!(found[1].target, None);
}
