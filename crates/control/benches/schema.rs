//! Time from a position to the motor schema's command.

use barrelman_control::{MotorSchema, Percept, Region};
use barrelman_vocab::profile::AxisRates;
use barrelman_vocab::{AngularRate, ImagePoint};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

#[divan::bench]
fn percept_and_command(bencher: Bencher<'_, '_>) {
    let rate = AngularRate::from_radians_per_second(0.3);
    let schema = MotorSchema::new(AxisRates { pan: rate, tilt: rate });
    let region = Region { a_px: 384.0, b_px: 180.0 };
    bencher.bench(|| {
        let percept = Percept::new(black_box(ImagePoint { x: 410.0, y: -77.0 }), region);
        schema.command(&percept)
    });
}
