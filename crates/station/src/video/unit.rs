//! Encoded units, as the whole program speaks of them: see [`barrelman_vocab::unit`].

pub use barrelman_vocab::unit::{EncodedUnit, Rotation, UnitCodec};
