//! The optimal law: both axes at once, started by a prediction.
//!
//! Two controllers share the prediction, the bearing filter and the camera model: [`RecedingHorizonLaw`]
//! computes the rates anew at each step, [`IntermittentLaw`] makes one movement for each excursion.
//! `docs/optimal-law.md` derives both.
//!
//! What must not be here: the decision whether the camera may move at all (`barrelman-pilot`'s safety), and
//! the vehicle's signs. Work per step: O(1), no allocation.

mod framing;
mod mean_bearing;
mod prediction;
mod running_mean;

mod circumstances;
mod intermittent;
mod intermittent_tuning;
mod movement;

mod receding_horizon;
mod tuning;

use barrelman_vocab::profile::VehicleProfile;
use barrelman_vocab::{CameraCommand, Framed, Timestamp};

pub use self::circumstances::Adapted;
pub use self::intermittent::IntermittentLaw;
pub use self::intermittent_tuning::IntermittentTuning;
pub use self::receding_horizon::RecedingHorizonLaw;
pub use self::tuning::{ModeTuning, OptimalSettings, Tuning};
use crate::camera_model::CameraModel;
use crate::law_input::LawInput;

/// The optimal law with its state.
///
/// ```
/// use barrelman_control::{CameraModel, LawInput, OptimalLaw, OptimalSettings, Percept, Region};
/// use barrelman_vocab::{ImagePoint, OptimalMode, PictureSize, Timestamp, VehicleProfile};
///
/// let profile = VehicleProfile::fotokite_pro();
/// let mut law = OptimalLaw::new(&OptimalSettings::new(OptimalMode::MinimumEnergy), &profile);
/// let camera = CameraModel::of(&profile);
/// let picture = PictureSize::new(640, 480);
/// let region = Region::from_shares(profile.region, picture);
/// let percept = Percept::new(ImagePoint { x: 250.0, y: 0.0 }, region);
/// let now = Timestamp::from_secs_f64(1.0);
/// let input = LawInput::measured(&percept, region, picture, now, now);
/// // The target is right of the region: the camera pans to the right.
/// assert!(law.command(&input, &camera).pan.radians_per_second() > 0.0);
/// ```
#[derive(Debug, Clone)]
pub struct OptimalLaw(Controller);

#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a pilot has one of them, and hardly ever moves it")]
enum Controller {
    RecedingHorizon(RecedingHorizonLaw),
    Intermittent(IntermittentLaw),
}

impl OptimalLaw {
    /// A law without observations.
    pub fn new(settings: &OptimalSettings, profile: &VehicleProfile) -> Self {
        Self::with_tuning(settings.tuning(), settings.framed, profile)
    }

    /// A law with a custom tuning.
    pub fn with_tuning(tuning: impl Into<ModeTuning>, framed: Framed, profile: &VehicleProfile) -> Self {
        Self(match tuning.into() {
            ModeTuning::RecedingHorizon(tuning) => {
                Controller::RecedingHorizon(RecedingHorizonLaw::new(tuning, framed, profile))
            }
            ModeTuning::Intermittent(tuning) => {
                Controller::Intermittent(IntermittentLaw::new(tuning, framed, profile))
            }
        })
    }

    /// Discards the observations of the target.
    pub fn reset_target(&mut self) {
        match &mut self.0 {
            Controller::RecedingHorizon(law) => law.reset_target(),
            Controller::Intermittent(law) => law.reset_target(),
        }
    }

    /// Notes that `command` is in force from `now` on.
    pub fn on_command_applied(&mut self, command: CameraCommand, now: Timestamp) {
        match &mut self.0 {
            Controller::RecedingHorizon(law) => law.on_command_applied(command, now),
            Controller::Intermittent(law) => law.on_command_applied(command, now),
        }
    }

    /// Computes the command of one step.
    pub fn command(&mut self, input: &LawInput<'_>, camera: &CameraModel) -> CameraCommand {
        match &mut self.0 {
            Controller::RecedingHorizon(law) => law.command(input, camera),
            Controller::Intermittent(law) => law.command(input, camera),
        }
    }
}
