//! The operator gateway: the way of every request from a page, a program or a terminal to the pilot.
//!
//! ```text
//! page, program --\                                  /-- accepted
//! terminal --------> Gateway ------(wake)---------> loop --> Pilot::step
//!   Stop ----------> StopLatch ---------------------/    \-- refused with the reason, or superseded
//! ```
//! A request waits in a bounded queue and gets exactly one [`Answer`]. A stop waits in no queue: see
//! [`StopLatch`]. Nothing here decides about the camera.

mod gateway;

mod answer;
mod answers;
mod stop_latch;

pub use answer::{Answer, AnswerSlot};
pub use answers::Answers;
pub(crate) use gateway::is_under_way;
pub use gateway::{Gateway, SessionRequest, Submitted};
pub use stop_latch::StopLatch;
