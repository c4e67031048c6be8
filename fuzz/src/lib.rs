//! What the fuzz targets do with the bytes that they are given.

pub mod tracker;
