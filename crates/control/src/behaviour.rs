//! Behaviour versions of the camera laws: which commands a law gives.
//!
//! Recordings, drives and campaigns store the version of the law that made them, so that a replay can tell a change
//! of the law from a fault. Raise a law's version by 1 in the commit that changes its results: when the same
//! localisations, the same vehicle profile and the same settings give a command that differs in any bit. The camera
//! model, the region and the percept count as part of each law that uses them. A change that leaves every command as
//! it was (speed, names, structure) does not raise the version. `CHANGELOG.md` names each rise.

/// Behaviour version of [`MotorSchema`](crate::MotorSchema).
pub const MOTOR_SCHEMA: u32 = 1;

/// Behaviour version of [`OptimalLaw`](crate::OptimalLaw), in all its modes but the intermittent one.
pub const OPTIMAL: u32 = 1;

/// Behaviour version of [`OptimalLaw`](crate::OptimalLaw) in its intermittent mode. 2: the prediction expects the target
/// to return to its mean direction. 3: the values depend on the sway, the steepness of the view and the target's usual rate. 4: and on the
/// delay and the lag of the camera; its ramps are a share of the slower axis' lag. 5: a camera of late video starts about as early as any
/// other.
pub const INTERMITTENT: u32 = 5;

/// Behaviour version of the PID on the picture's centre. 2: rates below the least rate of an axis are not commanded.
pub const CENTRE: u32 = 2;
