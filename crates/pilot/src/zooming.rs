//! The zoom of a pilot's camera: whether the target's size is kept, and by what.

use barrelman_control::size_keeping::SizeKeeper;
use barrelman_vocab::VehicleProfile;

use crate::growth::ZoomGrowth;

/// The zoom of a camera that has one.
#[derive(Debug)]
pub(crate) struct Zooming {
    pub(crate) keeper: SizeKeeper,
    pub(crate) keeps_size: bool,
    /// Used where the camera does not report its field of view.
    pub(crate) growth: ZoomGrowth,
}

impl Zooming {
    /// At the widest view; `None`: the camera does not zoom.
    pub(crate) fn new(profile: &VehicleProfile) -> Option<Self> {
        let zoom = profile.zoom?;
        let keeper = SizeKeeper::new(profile.size, zoom, profile.camera.focal_share);
        let keeps_size = profile.size.is_on_at_start;
        Some(Self { keeper, keeps_size, growth: ZoomGrowth::default() })
    }

    /// Another target is followed from now on.
    pub(crate) fn begin_target(&mut self) {
        self.keeper.reset_target();
    }
}
