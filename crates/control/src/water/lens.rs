//! Pixel coordinates to normalised coordinates (tangents of the line of sight, x right, y down) and back.
//!
//! The barrel model maps pixels to lines of sight in closed form, the model of Brown and Conrady lines of
//! sight to pixels (Brown, 1971; coefficients as in OpenCV). The other directions are solved by Newton's
//! method to [`RESIDUAL`]. A model of Brown and Conrady folds over at some radius, beyond which one pixel
//! stands for several lines of sight: the inverse is the branch around the principal point, and there is none
//! beyond the fold.

use barrelman_vocab::{BrownConrady, Distortion, Lens, PixelPoint};

/// Normalised coordinates: right and down for each unit ahead.
pub type Tangents = [f64; 2];

/// A 2 x 2 matrix by rows.
pub(super) type Matrix2 = [[f64; 2]; 2];

/// Largest error of an inverted lens in normalised coordinates.
pub const RESIDUAL: f64 = 1e-12;
/// Most Newton steps; from the distorted point, usual lenses need four.
const MAX_STEPS: usize = 30;
/// Most halvings of a Newton step that does not reduce the error.
const MAX_HALVINGS: usize = 10;

/// The pixel of a line of sight. `None`: the lens maps this line of sight to no pixel, because it lies beyond
/// the fold of the model.
pub fn pixel_of(lens: &Lens, tangents: Tangents) -> Option<PixelPoint> {
    let [x, y] = match lens.distortion {
        Distortion::None => tangents,
        Distortion::Barrel { k } => with_barrel(k, tangents),
        Distortion::BrownConrady(model) => {
            let (distorted, slope) = brown_conrady(&model, tangents);
            if !is_before_fold(&model, tangents, &slope) {
                return None;
            }
            distorted
        }
    };
    let pixel =
        PixelPoint { u: lens.principal.u + lens.focal_px.0 * x, v: lens.principal.v + lens.focal_px.1 * y };
    (pixel.u.is_finite() && pixel.v.is_finite()).then_some(pixel)
}

/// The line of sight of a pixel, and its derivatives: `slope[i][j]` is the change of tangent i for each pixel
/// of u (j = 0) or v (j = 1). `None`: the lens maps no line of sight to this pixel.
pub(super) fn line_of_sight(lens: &Lens, pixel: PixelPoint) -> Option<(Tangents, Matrix2)> {
    let per_px = [1.0 / lens.focal_px.0, 1.0 / lens.focal_px.1];
    let [x, y] = [(pixel.u - lens.principal.u) * per_px[0], (pixel.v - lens.principal.v) * per_px[1]];
    let (tangents, slope) = match lens.distortion {
        Distortion::None => ([x, y], [[1.0, 0.0], [0.0, 1.0]]),
        Distortion::Barrel { k } => {
            let stretch = 1.0 + k * (x * x + y * y);
            let slope =
                [[stretch + 2.0 * k * x * x, 2.0 * k * x * y], [2.0 * k * x * y, stretch + 2.0 * k * y * y]];
            ([x * stretch, y * stretch], slope)
        }
        Distortion::BrownConrady(model) => {
            let tangents = without_brown_conrady(&model, [x, y])?;
            let (_, forward) = brown_conrady(&model, tangents);
            (tangents, inverse(&forward)?)
        }
    };
    let is_finite = tangents[0].is_finite() && tangents[1].is_finite();
    is_finite.then(|| {
        let slope = slope.map(|row| [row[0] * per_px[0], row[1] * per_px[1]]);
        (tangents, slope)
    })
}

/// The line of sight of a pixel. `None`: the lens maps no line of sight to this pixel.
pub fn tangents_of(lens: &Lens, pixel: PixelPoint) -> Option<Tangents> {
    line_of_sight(lens, pixel).map(|(tangents, _)| tangents)
}

/// Distorted coordinates by the barrel model: r with r (1 + k r²) = r_pinhole, by Newton's method from above,
/// where the cubic is convex and the method cannot fail.
fn with_barrel(k: f64, [x, y]: Tangents) -> Tangents {
    let pinhole = libm::sqrt(x * x + y * y);
    if pinhole == 0.0 || k <= 0.0 {
        return [x, y];
    }
    let mut r = pinhole;
    for _ in 0..MAX_STEPS {
        let step = (r * (1.0 + k * r * r) - pinhole) / (1.0 + 3.0 * k * r * r);
        r -= step;
        if step.abs() <= f64::EPSILON * pinhole {
            break;
        }
    }
    let share = r / pinhole;
    [x * share, y * share]
}

/// Distorted coordinates by the model of Brown and Conrady, and their derivatives.
fn brown_conrady(model: &BrownConrady, [x, y]: Tangents) -> (Tangents, Matrix2) {
    let BrownConrady { k1, k2, p1, p2, k3 } = *model;
    let (xx, xy, yy) = (x * x, x * y, y * y);
    let square = xx + yy;
    let scale = 1.0 + square * (k1 + square * (k2 + square * k3));
    // Twice the derivative of the scale by r².
    let growth = 2.0 * (k1 + square * (2.0 * k2 + square * 3.0 * k3));
    let distorted = [
        scale * x + 2.0 * p1 * xy + p2 * (square + 2.0 * xx),
        scale * y + p1 * (square + 2.0 * yy) + 2.0 * p2 * xy,
    ];
    let across = growth * xy + 2.0 * (p1 * x + p2 * y);
    let slope = [
        [scale + growth * xx + 2.0 * p1 * y + 6.0 * p2 * x, across],
        [across, scale + growth * yy + 6.0 * p1 * y + 2.0 * p2 * x],
    ];
    (distorted, slope)
}

/// Whether a line of sight lies before the fold: the distorted radius grows all the way to it, and the map
/// keeps its orientation there.
fn is_before_fold(model: &BrownConrady, [x, y]: Tangents, slope: &Matrix2) -> bool {
    let square = x * x + y * y;
    let BrownConrady { k1, k2, k3, .. } = *model;
    // The derivative of r s(r) by r, as a cubic of r²; it must stay positive from 0 on.
    let growth = |q: f64| 1.0 + q * (3.0 * k1 + q * (5.0 * k2 + q * 7.0 * k3));
    // Its least value before `square` is at an end or at a root of its own derivative.
    let (a, b, c) = (21.0 * k3, 10.0 * k2, 3.0 * k1);
    let discriminant = b * b - 4.0 * a * c;
    let turns = if a.abs() > 1e-15 && discriminant >= 0.0 {
        let root = libm::sqrt(discriminant);
        [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)]
    } else if b != 0.0 {
        [-c / b, -c / b]
    } else {
        [0.0, 0.0]
    };
    let grows = growth(square) > 0.0
        && turns.into_iter().filter(|turn| (0.0..square).contains(turn)).all(|turn| growth(turn) > 0.0);
    grows && determinant(slope) > 0.0 && slope[0][0] + slope[1][1] > 0.0
}

/// The line of sight of distorted coordinates by the model of Brown and Conrady: Newton's method with steps
/// that are halved until the error decreases.
fn without_brown_conrady(model: &BrownConrady, distorted: Tangents) -> Option<Tangents> {
    let error_at = |tangents: Tangents| {
        let ([x, y], slope) = brown_conrady(model, tangents);
        ([x - distorted[0], y - distorted[1]], slope)
    };
    let norm = |[x, y]: Tangents| x * x + y * y;
    let mut tangents = distorted;
    let (mut error, mut slope) = error_at(tangents);
    if !is_before_fold(model, tangents, &slope) {
        // The start lies beyond the fold: begin at the axis.
        tangents = [0.0, 0.0];
        (error, slope) = error_at(tangents);
    }
    let goal = RESIDUAL * (1.0 + libm::sqrt(norm(distorted)));
    for _ in 0..MAX_STEPS {
        let back = inverse(&slope)?;
        let step =
            [back[0][0] * error[0] + back[0][1] * error[1], back[1][0] * error[0] + back[1][1] * error[1]];
        if norm(step) <= 0.01 * goal * goal && norm(error) <= 0.01 * goal * goal {
            break;
        }
        let mut share = 1.0;
        for _ in 0..MAX_HALVINGS {
            let next = [tangents[0] - share * step[0], tangents[1] - share * step[1]];
            let (next_error, next_slope) = error_at(next);
            if norm(next_error) < norm(error) && is_before_fold(model, next, &next_slope) {
                (tangents, error, slope) = (next, next_error, next_slope);
                break;
            }
            share *= 0.5;
        }
        if share <= 1.0 / 1024.0 {
            break;
        }
    }
    (norm(error) <= goal * goal && is_before_fold(model, tangents, &slope)).then_some(tangents)
}

fn determinant(m: &Matrix2) -> f64 {
    m[0][0] * m[1][1] - m[0][1] * m[1][0]
}

/// The inverse of a matrix; `None` where it is singular.
fn inverse(m: &Matrix2) -> Option<Matrix2> {
    let scale = 1.0 / determinant(m);
    scale.is_finite().then(|| [[scale * m[1][1], -scale * m[0][1]], [-scale * m[1][0], scale * m[0][0]]])
}
