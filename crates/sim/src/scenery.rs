//! The objects beside the target: where they are at any tick.

use barrelman_vocab::Angle;

use crate::pose::{BodyPose, WorldPoint};
use crate::random::{CounterRng, Stream};
use crate::sea::Sea;
use crate::snapshot::{ObjectKind, SceneObject};
use crate::tick::TICK_S;

/// An object and its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct ObjectScript {
    /// Kind of the object.
    pub kind: ObjectKind,
    /// Initial position along x and y, metres.
    pub at: (f64, f64),
    /// Standard deviation of each initial coordinate from trial to trial, metres.
    pub jitter_m: f64,
    /// Heading: 0 along x, anticlockwise.
    pub heading: Angle,
    /// Initial velocity along x and y, m/s.
    pub velocity_m_per_s: (f64, f64),
    /// Time after which the object reverses, again and again, seconds; `None`: never.
    pub turns_after_s: Option<f64>,
    /// Whether the object drifts with the current, the waves and a little with the wind, on top of its own
    /// velocity.
    pub drifts: bool,
}

/// Drift of a person or a life jacket for each m/s of the wind, 10 m above the water: the leeway of a person
/// who floats upright (Allen and Plourde, 1999).
const LEEWAY: f64 = 0.011;

/// Velocity over ground of what drifts, along the world's x and y, m/s. Gusts are left out.
pub fn drift_m_per_s(sea: &Sea) -> (f64, f64) {
    let (current, stokes, wind) = (sea.current(), sea.stokes_drift(), sea.wind());
    let (sin, cos) = libm::sincos(wind.towards.radians());
    let leeway = LEEWAY * wind.speed_mps;
    (current.0 + stokes.0 + leeway * cos, current.1 + stokes.1 + leeway * sin)
}

/// All objects of a trial beside the target.
#[derive(Debug, Clone)]
pub struct Scenery {
    objects: Vec<(ObjectScript, (f64, f64), u64)>,
}

impl Scenery {
    /// The objects of a trial.
    pub fn new(scripts: &[ObjectScript], seed: u64) -> Self {
        let rng = CounterRng::new(seed, Stream::Scenery);
        let objects = scripts.iter().enumerate().map(|(index, script)| {
            let off = |which: u64| script.jitter_m * rng.normal(4 * index as u64 + which);
            let own_seed = seed.wrapping_mul(0x9E37_79B9).wrapping_add(index as u64);
            (script.clone(), (script.at.0 + off(0), script.at.1 + off(1)), own_seed)
        });
        Self { objects: objects.collect() }
    }

    /// Writes the objects at a tick into `out`, reusing its memory; floating objects follow the waves.
    pub fn write_objects(&self, tick: u64, sea: Option<&Sea>, out: &mut Vec<SceneObject>) {
        out.clear();
        let drift = sea.map(drift_m_per_s);
        out.extend(self.objects.iter().map(|(script, start, seed)| {
            let at_s = tick as f64 * TICK_S;
            // There and back: a triangle wave of the time.
            let elapsed_s = script.turns_after_s.map_or(at_s, |turn_s| {
                let phase = at_s % (2.0 * turn_s);
                if phase < turn_s { phase } else { 2.0 * turn_s - phase }
            });
            let (mut x, mut y) = (
                start.0 + elapsed_s * script.velocity_m_per_s.0,
                start.1 + elapsed_s * script.velocity_m_per_s.1,
            );
            if let Some(drift) = drift.filter(|_| script.drifts) {
                x += at_s * drift.0;
                y += at_s * drift.1;
            }
            let fixed =
                matches!(script.kind, ObjectKind::Pier { .. } | ObjectKind::Shore | ObjectKind::FloorMark);
            let surface = sea.filter(|_| !fixed).map(|sea| sea.surface_at(x, y, tick)).unwrap_or_default();
            let (s, c) = libm::sincos(script.heading.radians());
            let (along, to_left) =
                (surface.slope.0 * c + surface.slope.1 * s, -surface.slope.0 * s + surface.slope.1 * c);
            SceneObject {
                kind: script.kind,
                pose: BodyPose {
                    position: WorldPoint { x, y, z: surface.elevation },
                    heading: script.heading,
                    pitch: Angle::from_radians(along),
                    roll: Angle::from_radians(to_left),
                },
                seed: *seed,
            }
        }));
    }
}
