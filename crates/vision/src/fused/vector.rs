//! Sums, differences and lengths in a plane: of places in the picture, and of chroma.

/// Right and down, or U and V.
pub(super) type Vector = (f32, f32);

pub(super) fn sum(a: Vector, b: Vector) -> Vector {
    (a.0 + b.0, a.1 + b.1)
}

pub(super) fn difference(a: Vector, b: Vector) -> Vector {
    (a.0 - b.0, a.1 - b.1)
}

pub(super) fn scaled(a: Vector, factor: f32) -> Vector {
    (factor * a.0, factor * a.1)
}

/// The inner product.
pub(super) fn product(a: Vector, b: Vector) -> f32 {
    a.0 * b.0 + a.1 * b.1
}

pub(super) fn length(a: Vector) -> f32 {
    libm::hypotf(a.0, a.1)
}
