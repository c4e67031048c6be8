//! Position, size and rotation of the target in the picture.

use barrelman_vocab::PictureSize;

use super::extent::Extent;
use crate::features::PatchPose;
use crate::fourier::SIDE;
use crate::gradients::CELL;
use crate::vector::{Vector, scaled, sum};

/// Limits of the target's box and of the search window. Settings without a figure were not measured
/// individually.
#[derive(Debug, Clone, Copy)]
pub(super) struct GeometrySettings {
    /// Minimum side of the target's upright box, and minimum length and breadth by a silhouette, pixels.
    /// Chroma has half the resolution of the picture: less than two samples do not give a breadth. With a
    /// lower minimum, boxes became strips.
    min_side_px: f32,
    /// Minimum side of the search window, lengths of the target.
    min_window_lengths: f32,
    /// Minimum side of the search window, pixels. A smaller window would not have a higher resolution.
    min_window_px: f32,
    /// Side of the square around the target that background registration leaves out, half lengths of the
    /// target.
    blanked_half_lengths: f32,
}

impl Default for GeometrySettings {
    fn default() -> Self {
        Self { min_side_px: 3.0, min_window_lengths: 2.0, min_window_px: 24.0, blanked_half_lengths: 2.2 }
    }
}

/// The target's pose and size in the last frame.
#[derive(Debug, Clone)]
pub(super) struct TargetGeometry {
    settings: GeometrySettings,
    /// Proportions, at the size of the selection.
    pub(super) extent: Extent,
    /// Root of the area of the selection's box, pixels.
    pub(super) initial_size_px: f32,
    /// Present size relative to that at the selection.
    pub(super) scale: f32,
    /// Rotation of the patches since the selection, radians clockwise.
    pub(super) patch_angle: f32,
    /// One end of the target's axis, radians clockwise from image right. It turns with `patch_angle` unless
    /// the silhouette gives a better axis.
    pub(super) axis: f32,
    /// Centre of the target's box, pixels.
    pub(super) centre: (f32, f32),
    /// From the place of the filter's response to the centre of the box, sizes.
    pub(super) offset: (f32, f32),
    /// Size of the picture that the pixel coordinates belong to.
    pub(super) picture: PictureSize,
}

impl TargetGeometry {
    /// The geometry of a selection with this centre and size (width, height), pixels.
    pub(super) fn new(centre: (f32, f32), (width, height): (f32, f32), picture: PictureSize) -> Self {
        Self {
            settings: GeometrySettings::default(),
            extent: Extent::Box { width, height },
            initial_size_px: (width * height).sqrt(),
            scale: 1.0,
            patch_angle: 0.0,
            axis: 0.0,
            centre,
            offset: (0.0, 0.0),
            picture,
        }
    }

    /// The target's size: root of the area of its box, pixels.
    pub(super) fn size_px(&self) -> f32 {
        self.initial_size_px * self.scale
    }

    /// Width and height of the picture, pixels.
    pub(super) fn picture_size(&self) -> (f32, f32) {
        (self.picture.width as f32, self.picture.height as f32)
    }

    /// Half axes of the target's ellipse, along and across its axis, pixels.
    pub(super) fn half_axes(&self) -> (f32, f32) {
        self.extent.half_axes(self.scale)
    }

    /// The longer half axis, pixels.
    pub(super) fn longer_half_axis(&self) -> f32 {
        let (along, across) = self.half_axes();
        along.max(across)
    }

    /// Width and height of the target's upright box, pixels.
    pub(super) fn upright_box(&self) -> (f32, f32) {
        self.extent.upright_box(self.scale, self.axis)
    }

    /// Pose of the search window around the target, for a side of `padding` sizes.
    pub(super) fn patch_pose(&self, padding: f64) -> PatchPose {
        let half = self.extent.half_axes(1.0);
        let side = (padding as f32 * self.initial_size_px)
            .max(self.settings.min_window_lengths * 2.0 * half.0.max(half.1))
            .max(self.settings.min_window_px);
        PatchPose {
            centre: self.centre,
            step: self.scale * side / (SIDE * CELL) as f32,
            angle: self.patch_angle,
        }
    }

    /// The target's axis if the target has turned with the patch.
    pub(super) fn axis_in(&self, pose: &PatchPose) -> f32 {
        match self.extent {
            Extent::Box { .. } => 0.0,
            Extent::Hull { .. } => self.axis + pose.angle - self.patch_angle,
        }
    }

    /// Side of the square that background registration leaves out, pixels.
    pub(super) fn blanked_side_px(&self) -> f32 {
        self.settings.blanked_half_lengths * self.longer_half_axis()
    }

    /// Multiplies the size by `factor`, unless the box would become too small or larger than the picture.
    pub(super) fn rescale(&mut self, factor: f32) {
        let scale = self.scale * factor;
        let (w, h) = self.extent.upright_box(scale, self.axis);
        let picture = self.picture_size();
        if factor.is_finite() && w.min(h) >= self.settings.min_side_px && w <= picture.0 && h <= picture.1
            || (factor - 1.0) * (scale - 1.0) < 0.0
        {
            self.scale = scale;
        }
    }

    /// Moves length and breadth towards measured ones (pixels) by the share `rate` of the logarithm.
    pub(super) fn stretch_to(&mut self, length: f32, breadth: f32, rate: f32) {
        let half = self.half_axes();
        let factor = |measured: f32, known: f32| libm::powf(measured / known, rate);
        let measured = (length.max(self.settings.min_side_px), breadth.max(self.settings.min_side_px));
        let (longer, wider) = (factor(measured.0, 2.0 * half.0), factor(measured.1, 2.0 * half.1));
        // The geometric mean is a change of size, the rest a change of proportions.
        let common = (longer * wider).sqrt();
        self.rescale(common);
        self.extent.stretch(longer / common, wider / common);
    }

    /// Centre of the box where the filter's response lies at `place`, pixels, within the picture.
    pub(super) fn box_centre_at(&self, place: (f32, f32)) -> (f32, f32) {
        self.clamped_to_picture(sum(place, scaled(self.offset, self.size_px())))
    }

    /// The point of the picture that is nearest to a place, pixels.
    pub(super) fn clamped_to_picture(&self, (u, v): Vector) -> Vector {
        let (width, height) = self.picture_size();
        (u.clamp(0.0, width), v.clamp(0.0, height))
    }

    /// Turns the target by this angle, radians clockwise. A box without an axis stays upright.
    pub(super) fn turn(&mut self, angle: f32) {
        self.patch_angle += angle;
        if let Extent::Hull { .. } = self.extent {
            self.axis += angle;
        }
    }

    /// Makes a box without an axis wider and higher by these factors, within the limits of minimum side and
    /// picture. The size with which the filter is sampled follows the box by the share `size_share` of the
    /// logarithm.
    pub(super) fn reshape_box(&mut self, wider: f32, higher: f32, size_share: f32) {
        let (w, h) = self.upright_box();
        let (picture, min_side) = (self.picture_size(), self.settings.min_side_px);
        let Extent::Box { width, height } = &mut self.extent else { return };
        for (side, present, factor, limit) in [(width, w, wider, picture.0), (height, h, higher, picture.1)] {
            let after = present * factor;
            if (after >= min_side || factor > 1.0) && (after <= limit || factor < 1.0) {
                *side *= factor;
            }
        }
        let Extent::Box { width, height } = self.extent else { return };
        let before = self.scale;
        self.rescale(libm::powf((width * height).sqrt() / self.initial_size_px, size_share));
        let factor = self.scale / before;
        self.extent = Extent::Box { width: width / factor, height: height / factor };
    }

    /// Whether part of the target's box lies outside the picture.
    pub(super) fn touches_border(&self) -> bool {
        self.is_cut_off(self.centre, scaled(self.upright_box(), 0.5))
    }

    /// The same where the filter's response lies at `place`, pixels.
    pub(super) fn touches_border_at(&self, place: Vector) -> bool {
        self.is_cut_off(self.box_centre_at(place), scaled(self.upright_box(), 0.5))
    }

    /// Whether part of a box with this centre and these half sides, pixels, lies outside the picture.
    pub(super) fn is_cut_off(&self, (u, v): Vector, half: Vector) -> bool {
        let (width, height) = self.picture_size();
        u < half.0 || v < half.1 || u > width - half.0 || v > height - half.1
    }

    /// Converts to pixels of a picture of another size with the same field of view. Returns the factors along
    /// u and v.
    pub(super) fn rescale_to_picture(&mut self, picture: PictureSize) -> (f32, f32) {
        let (u, v) = (
            picture.width as f32 / self.picture.width as f32,
            picture.height as f32 / self.picture.height as f32,
        );
        self.centre = (self.centre.0 * u, self.centre.1 * v);
        self.scale *= (u * v).sqrt();
        self.picture = picture;
        (u, v)
    }

    /// Turns the target by half a revolution: exchanges the ends of its axis.
    pub(super) fn reverse_axis(&mut self) {
        self.turn(core::f32::consts::PI);
    }
}
