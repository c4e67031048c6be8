//! The objects beside the target, and the marks of its path.

use barrelman_sim::scenario::TargetScript;
use barrelman_sim::scenery::ObjectScript;
use barrelman_sim::snapshot::ObjectKind;
use barrelman_vocab::Angle;

use super::target::WORLD_M;
use crate::scenario::ScenarioError;
use crate::scenario::file::{ScenarioFile, SceneObjectName, SceneObjectSection};
use crate::scenario::range::{angle_within, within};

/// The distance of marks on the water from the path, to its left, metres.
const MARK_OFFSET_M: f64 = 2.0;

/// The smallest distance between two marks on the water, metres.
const MIN_MARK_DISTANCE_M: f64 = 5.0;

/// The objects of a scenario: the marks of the path, then the objects of the file in their order.
pub(super) fn objects(
    file: &ScenarioFile,
    target: &TargetScript,
) -> Result<Vec<ObjectScript>, ScenarioError> {
    let way_points = match target {
        TargetScript::Pursuit(script) => &script.way_points,
        TargetScript::Boat(script) => &script.way_points,
    };
    let mut all = if file.marks { marks(way_points, file.water.is_some()) } else { Vec::new() };
    for (index, section) in file.object.iter().enumerate() {
        all.push(object(&format!("object.{index}"), section)?);
    }
    Ok(all)
}

/// The marks of a path. On a floor, a painted mark at each way-point. On water, small buoys beside the path,
/// so that the boat does not run over them; a buoy closer than [`MIN_MARK_DISTANCE_M`] to an earlier buoy is
/// left out.
fn marks(way_points: &[(f64, f64)], on_water: bool) -> Vec<ObjectScript> {
    let mark = |kind, at| ObjectScript {
        kind,
        at,
        jitter_m: 0.0,
        heading: Angle::ZERO,
        velocity_m_per_s: (0.0, 0.0),
        turns_after_s: None,
        drifts: false,
    };
    if !on_water {
        return way_points.iter().map(|at| mark(ObjectKind::FloorMark, *at)).collect();
    }
    let mut marks: Vec<ObjectScript> = Vec::new();
    for (index, at) in way_points.iter().enumerate() {
        let (before, after) =
            (way_points[index.saturating_sub(1)], way_points[(index + 1).min(way_points.len() - 1)]);
        let (dx, dy) = (after.0 - before.0, after.1 - before.1);
        let length = libm::hypot(dx, dy).max(f64::MIN_POSITIVE);
        let beside = (at.0 - MARK_OFFSET_M * dy / length, at.1 + MARK_OFFSET_M * dx / length);
        let is_near = |mark: &ObjectScript| {
            libm::hypot(mark.at.0 - beside.0, mark.at.1 - beside.1) < MIN_MARK_DISTANCE_M
        };
        if !marks.iter().any(is_near) {
            marks.push(mark(ObjectKind::MarkBuoy, beside));
        }
    }
    marks
}

fn object(at: &str, section: &SceneObjectSection) -> Result<ObjectScript, ScenarioError> {
    let key = |name: &str| format!("{at}.{name}");
    let kind = match (section.kind, section.size_m) {
        (SceneObjectName::Pier, Some([length, breadth])) => ObjectKind::Pier {
            length_m: within(&key("size_m"), length, 1.0, 500.0, "metres")?,
            breadth_m: within(&key("size_m"), breadth, 0.5, 50.0, "metres")?,
        },
        (SceneObjectName::Pier, None) => {
            return Err(ScenarioError::invalid(key("size_m"), "a pier needs one"));
        }
        (_, Some(_)) => return Err(ScenarioError::invalid(key("size_m"), "only a pier has one")),
        (SceneObjectName::Buoy, None) => ObjectKind::Buoy,
        (SceneObjectName::LifeJacket, None) => ObjectKind::LifeJacket,
        (SceneObjectName::Swimmer, None) => ObjectKind::Swimmer,
        (SceneObjectName::RedCraft, None) => ObjectKind::RedCraft,
        (SceneObjectName::Shore, None) => ObjectKind::Shore,
    };
    let place = |value: f64| within(&key("at"), value, -WORLD_M, WORLD_M, "metres");
    let speed = |value: f64| within(&key("velocity_m_per_s"), value, -20.0, 20.0, "m/s");
    let ([x, y], [vx, vy]) = (section.at, section.velocity_m_per_s);
    Ok(ObjectScript {
        kind,
        at: (place(x)?, place(y)?),
        jitter_m: within(&key("jitter_m"), section.jitter_m, 0.0, 1000.0, "metres")?,
        heading: angle_within(&key("heading_deg"), section.heading_deg, -360.0, 360.0)?,
        velocity_m_per_s: (speed(vx)?, speed(vy)?),
        turns_after_s: section
            .turns_after_s
            .map(|after| within(&key("turns_after_s"), after, 0.1, 3600.0, "seconds"))
            .transpose()?,
        drifts: section.drifts && !matches!(kind, ObjectKind::Pier { .. } | ObjectKind::Shore),
    })
}
