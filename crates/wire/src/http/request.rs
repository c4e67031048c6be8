//! A request, and what its protocol says of it.

use core::time::Duration;

/// A call with the number that its answer bears.
#[derive(Debug, Clone, PartialEq)]
pub struct Request<C> {
    /// The number, unique in a session.
    pub id: u64,
    /// The lane on which it is sent.
    pub lane: Lane,
    /// What is asked.
    pub call: C,
}

/// What can be asked of a vehicle over HTTP.
pub trait HttpCall: Clone + Send + 'static {
    /// The lanes that the protocol uses.
    const LANES: &'static [Lane];
    /// The type of a body, as the header `Content-Type` names it.
    const CONTENT_TYPE: &'static str;

    /// The longest time until the answer of a call on this lane.
    fn timeout(lane: Lane) -> Duration;

    /// The method.
    fn method(&self) -> Method;

    /// The path below the base address.
    fn path(&self) -> String;

    /// The body.
    fn body(&self) -> Option<String>;
}

/// A method of HTTP.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Reads.
    Get,
    /// Changes.
    Post,
}

impl Method {
    /// The name in a request.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Get => "GET",
            Self::Post => "POST",
        }
    }
}

/// What may be under way at the same time: one call of each lane. A port keeps a connection for each, so that
/// a call that hangs holds up no call of another lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Lane {
    /// Commands that end the motion.
    Stop,
    /// Commands to turn.
    Turn,
    /// Who controls.
    Control,
    /// Where the camera points.
    Camera,
    /// All other states.
    State,
    /// A WebSocket.
    Socket,
}
