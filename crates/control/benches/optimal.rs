//! Time of one step of the optimal law: at rest, moving, and with a target far outside of the region.

use barrelman_control::optimal::OptimalSettings;
use barrelman_control::{CameraLaw, LawInput, LawSettings, Percept, Region};
use barrelman_vocab::OptimalMode;
use barrelman_vocab::{ImagePoint, PictureSize, Timestamp, VehicleProfile};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// Steps of one period of the target's motion.
const SWING: u32 = 240;

/// One step, including the camera model, with a target that oscillates with this amplitude: the mean over a
/// period.
#[divan::bench(args = [60.0, 200.0, 300.0], sample_count = 500, sample_size = SWING)]
fn intermittent(bencher: Bencher<'_, '_>, reach_px: f64) {
    step(bencher, reach_px, OptimalMode::Intermittent);
}

/// The same of the mode with the least energy.
#[divan::bench(args = [60.0, 200.0, 300.0], sample_count = 500, sample_size = SWING)]
fn minimum_energy(bencher: Bencher<'_, '_>, reach_px: f64) {
    step(bencher, reach_px, OptimalMode::MinimumEnergy);
}

fn step(bencher: Bencher<'_, '_>, reach_px: f64, mode: OptimalMode) {
    let profile = VehicleProfile::fotokite_pro();
    let settings = LawSettings::Optimal(OptimalSettings::new(mode));
    let mut law = CameraLaw::new(settings, &profile);
    let picture = PictureSize::new(640, 480);
    let region = Region::from_shares(profile.region, picture);
    let percepts: Vec<_> = (0..SWING)
        .map(|step| {
            let swing = 1.0 - (f64::from(step) / f64::from(SWING / 4) - 2.0).abs();
            Percept::new(ImagePoint { x: reach_px * swing, y: 0.3 * reach_px * swing }, region)
        })
        .collect();
    let mut frame = 0_u64;
    bencher.bench_local(|| {
        frame += 1;
        let captured = Timestamp::from_nanos(frame * 33_333_333);
        let now = Timestamp::from_nanos(frame * 33_333_333 + 100_000_000);
        let percept = black_box(&percepts[(frame % u64::from(SWING)) as usize]);
        let command = law.command(&LawInput::measured(percept, region, picture, captured, now));
        law.on_command_applied(command, now);
        command
    });
}
