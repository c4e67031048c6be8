//! The priority of a decoder.

/// The priority of the decoder: low latency or all frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DecodeMode {
    /// Each picture as soon as its unit arrives.
    Live,
    /// All pictures, in display order.
    File,
}
