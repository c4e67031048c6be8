//! The sea's waves: their height by the sea state, and their motion.

use barrelman_sim::{Sea, SeaState, Wind};
use barrelman_vocab::Angle;

fn sea(number: u8, seed: u64) -> Sea {
    let state = SeaState::ALL[usize::from(number)];
    Sea::new(state, Wind { speed_mps: state.wind_mps(), towards: Angle::from_degrees(37.0) }, seed)
}

#[test]
fn waves_are_as_high_as_the_sea_state_says() {
    for number in 0..5 {
        let sea = sea(number, 3);
        let side = sea.tile_side_m();
        let mut squares = 0.0;
        let count = 4_000;
        for i in 0..count {
            let (x, y) = (side * f64::from(i * 37 % 199) / 199.0, side * f64::from(i * 53 % 211) / 211.0);
            let eta = sea.surface_at(x, y, u64::from(i as u32 * 17)).elevation;
            squares += eta * eta;
        }
        let significant = 4.0 * libm::sqrt(squares / f64::from(count));
        let wanted = SeaState::ALL[usize::from(number)].significant_height_m();
        // The estimate from random points and ticks of 64 waves scatters by a few per cent.
        assert!(
            (significant / wanted - 1.0).abs() < 0.08,
            "state {number}: {significant} m, wanted {wanted}"
        );
    }
}

#[test]
fn the_surface_repeats_after_the_sea_s_side() {
    let sea = sea(2, 9);
    for (x, y, tick) in [(0.0, 0.0, 0), (13.7, -4.0, 700), (-250.0, 99.0, 12_345)] {
        let (here, there) = (
            sea.surface_at(x, y, tick),
            sea.surface_at(x + sea.tile_side_m(), y - 2.0 * sea.tile_side_m(), tick),
        );
        assert!((here.elevation - there.elevation).abs() < 1e-9);
    }
}

#[test]
fn slope_and_velocity_are_those_of_the_elevation() {
    let sea = sea(3, 5);
    let (x, y, tick, step) = (21.0, -8.0, 4_000, 1e-4);
    let here = sea.surface_at(x, y, tick);
    let by_x = (sea.surface_at(x + step, y, tick).elevation - sea.surface_at(x - step, y, tick).elevation)
        / (2.0 * step);
    let by_y = (sea.surface_at(x, y + step, tick).elevation - sea.surface_at(x, y - step, tick).elevation)
        / (2.0 * step);
    assert!((here.slope.0 - by_x).abs() < 1e-6 && (here.slope.1 - by_y).abs() < 1e-6);
    // Over two ticks of 1/120 s the rate is a mean: near the rate at the middle.
    let rise = (sea.surface_at(x, y, tick + 1).elevation - sea.surface_at(x, y, tick - 1).elevation) * 60.0;
    assert!((here.velocity.2 - rise).abs() < 2e-3, "{} and {rise}", here.velocity.2);
}

#[test]
fn the_same_seed_gives_the_same_sea_and_another_another() {
    assert_eq!(sea(2, 1), sea(2, 1));
    assert_ne!(sea(2, 1).surface_at(1.0, 2.0, 3), sea(2, 2).surface_at(1.0, 2.0, 3));
}
