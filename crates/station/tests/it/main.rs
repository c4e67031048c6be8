//! What the station does, tested from outside.

mod overlay;
