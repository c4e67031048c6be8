//! Time of one step of the guidance laws.

use barrelman_control::guidance::{
    BoatFix, Destination, GuidanceInput, KeepOut, LabInput, LabLaw, LabSettings, LineOfSight,
    LineOfSightTuning, VesselLimits, VesselModel,
};
use barrelman_vocab::{PixelPoint, Timestamp, WaterCovariance, WaterFix, WaterPoint};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

const FRAME_NS: u64 = 66_666_667;
const LATENCY_NS: u64 = 250_000_000;

/// One step with a fix, a person to go to, and this number of circles, some of which are in the way.
#[divan::bench(args = [0, 2, 8], sample_count = 500, sample_size = 200)]
fn line_of_sight(bencher: Bencher<'_, '_>, circles: usize) {
    let mut law = LineOfSight::new(LineOfSightTuning::DEFAULT, VesselModel::JET);
    let keep_outs: Vec<KeepOut> = (0..circles)
        .map(|index| KeepOut {
            centre: WaterPoint { x: 1.5 * index as f64 - 3.0, y: 30.0 + 3.0 * index as f64 },
            radius_m: 3.0,
        })
        .collect();
    let mut frame = 0_u64;
    bencher.bench_local(|| {
        frame += 1;
        let captured = Timestamp::from_nanos(frame * FRAME_NS);
        let now = Timestamp::from_nanos(frame * FRAME_NS + LATENCY_NS);
        // There and back: the boat never arrives.
        let y = ((frame % 400) as f64 - 200.0).abs() * 0.1;
        let point = WaterPoint { x: 0.3 * libm::sin(y), y };
        let fix = BoatFix {
            captured,
            water: WaterFix { point, covariance: WaterCovariance::isotropic(0.1) },
            heading: None,
            is_commanded: true,
            sway_per_s: None,
        };
        let step = law.step(black_box(&GuidanceInput {
            now,
            fix: Some(fix),
            destination: Some(Destination::Person {
                at: WaterPoint { x: 2.0, y: 80.0 },
                velocity_m_per_s: (0.0, 0.0),
                stand_off_m: 2.0,
                uncertainty_m: 0.0,
            }),
            route: 1,
            way_points: &[],
            keep_outs: &keep_outs,
            limits: VesselLimits::DEFAULT,
        }));
        law.on_command_applied(step.command, now);
        step
    });
}

/// One step of the laboratory's law.
#[divan::bench(sample_count = 500, sample_size = 200)]
fn lab(bencher: Bencher<'_, '_>) {
    let mut law = LabLaw::new(LabSettings::PAPER);
    let mut frame = 0_u64;
    bencher.bench_local(|| {
        frame += 1;
        let (sin, cos) = libm::sincos(0.02 * frame as f64);
        law.step(black_box(&LabInput {
            now: Timestamp::from_nanos(frame * 2 * FRAME_NS),
            boat: Some(PixelPoint { u: 640.0 + 200.0 * cos, v: 360.0 + 200.0 * sin }),
            target: Some(PixelPoint { u: 100.0, v: 100.0 }),
        }))
    });
}
