//! The zoom of a pilot's camera: whether the target's size is kept, and by what.

use barrelman_control::size_keeping::SizeKeeper;
use barrelman_vocab::VehicleProfile;

/// The zoom of a camera that has one.
#[derive(Debug, Clone)]
pub(crate) struct Zooming {
    pub(crate) keeper: SizeKeeper,
    pub(crate) keeps_size: bool,
}

impl Zooming {
    /// At the widest view; `None`: the camera does not zoom.
    pub(crate) fn new(profile: &VehicleProfile) -> Option<Self> {
        let zoom = profile.zoom?;
        let keeper = SizeKeeper::new(profile.size, zoom, profile.camera.focal_share);
        Some(Self { keeper, keeps_size: profile.size.is_on_at_start })
    }

    /// Another target is followed from now on.
    pub(crate) fn begin_target(&mut self) {
        self.keeper.reset_target();
    }
}
