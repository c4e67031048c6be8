//! Sums, differences, lengths and rotations in a plane: of places in the picture, and of chroma.

/// Right and down, or U and V.
pub(crate) type Vector = (f32, f32);

pub(crate) fn sum(a: Vector, b: Vector) -> Vector {
    (a.0 + b.0, a.1 + b.1)
}

pub(crate) fn difference(a: Vector, b: Vector) -> Vector {
    (a.0 - b.0, a.1 - b.1)
}

pub(crate) fn scaled(a: Vector, factor: f32) -> Vector {
    (factor * a.0, factor * a.1)
}

/// The inner product.
pub(crate) fn product(a: Vector, b: Vector) -> f32 {
    a.0 * b.0 + a.1 * b.1
}

pub(crate) fn length((right, down): Vector) -> f32 {
    libm::hypotf(right, down)
}

pub(crate) fn distance(a: Vector, b: Vector) -> f32 {
    length(difference(a, b))
}

/// A rotation by an angle, clockwise as seen in the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rotation {
    pub(crate) cos: f32,
    pub(crate) sin: f32,
}

impl Rotation {
    /// A rotation by an angle in radians.
    pub(crate) fn by(angle: f32) -> Self {
        Self { cos: libm::cosf(angle), sin: libm::sinf(angle) }
    }

    /// The vector with these components along and across the rotated axes.
    #[inline(always)]
    pub(crate) fn apply(self, (along, across): Vector) -> Vector {
        (along * self.cos - across * self.sin, along * self.sin + across * self.cos)
    }

    /// The place at this vector, along and across the rotated axes, from an origin. Rounded differently than
    /// the sum of the origin and [`Self::apply`].
    pub(crate) fn place_from(self, origin: Vector, (along, across): Vector) -> Vector {
        (origin.0 + along * self.cos - across * self.sin, origin.1 + along * self.sin + across * self.cos)
    }

    /// The components of a vector along and across the rotated axes.
    #[inline(always)]
    pub(crate) fn undo(self, (right, down): Vector) -> Vector {
        (right * self.cos + down * self.sin, down * self.cos - right * self.sin)
    }
}
