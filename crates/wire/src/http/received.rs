//! What comes from the vehicle, or from the port that speaks with it.

/// A packet that a session receives.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Received {
    /// The answer to a request.
    Answer {
        /// The request's number.
        id: u64,
        /// The status of HTTP.
        status: u16,
        /// The body.
        body: Vec<u8>,
    },
    /// A request had no answer in its time, or no connection.
    NoAnswer {
        /// The request's number.
        id: u64,
    },
    /// A message of the WebSocket.
    Message(Vec<u8>),
    /// The WebSocket has ended.
    SocketEnded,
}
