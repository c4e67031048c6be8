//! Pictures and encoded bytes: H.264 and JPEG both ways, PNG to pictures; other formats through
//! [`crate::media`].

pub mod decoder;
mod h264;
mod huffman;
pub mod mode;
pub(crate) mod pending;

pub mod annexb;
pub mod pool;
pub(crate) mod sps;
mod still;

pub mod encoder;
mod encoder_log;
pub mod jpeg;
pub mod png_file;
