//! Behaviour version of the pilot: what it makes of the same inputs, tracks and advice.
//!
//! Recordings state the version of the pilot that made them, and a replay runs the pilot by that version's rules. Raise the
//! version in the commit that adds a rule to the old ones, and keep the old ones for replays.

/// The version of the pilots that stated none.
pub const FIRST: u32 = 1;

/// 2: the net yaw is limited; a picture that turns against the command stops the camera; a track that was measured
/// elsewhere counts as video also while the target is lost.
pub const OPPOSED_MOTION: u32 = 2;

/// 3: in calm air, a picture that turns against the command stops the camera after 0.3 s.
pub const CALM_AIR: u32 = 3;

/// 4: frames that confirm a selection need a confidence of 0.7, not of 0.5.
pub const SURE_SELECTION: u32 = 4;

/// 5: the places of boat and marks are corrected by an estimated displacement of the camera.
pub const DISPLACED_CAMERA: u32 = 5;

/// 6: a guided boat that does not answer its commands is stopped.
pub const ANSWERING_BOAT: u32 = 6;

/// 7: a mark that was set while height or tilt were not known gets its place on the water when they are, and a boat that is guided
/// over the water waits while a mark that it must regard has none; marks on a picture that is not taken yet are refused.
pub const PLACED_MARKS: u32 = 7;

/// 8: a boat that is guided over the water waits for 5 s at most while it has no place there, and goes away from a person only where
/// its bow is known; a search goes by the present field of view, and does not begin while a selection is not confirmed.
pub const BOW_BEFORE_RETREAT: u32 = 8;

/// The version of this pilot. 9:
///
/// - A person's mark that is moved again within 2 s tells no drift.
/// - Where a selection replaces one that the tracker follows already and that is not confirmed, and is refused, nothing is followed.
/// - A mark that was set or moved before any tilt was reported gets no place on the water.
/// - A boat that is guided in the picture waits for 5 s at most while its destination is behind the camera.
/// - Go needs fresh video.
/// - A boat at rest before a person goes away from the person only where it can come to rest before every circle.
/// - The way-points begin anew only where one of them changes, or which mark is the destination.
pub const NEWEST: u32 = 9;
