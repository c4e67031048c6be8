//! `barrelman-ros2`: Barrelman as a node of ROS 2.
//!
//! ```text
//!   barrelman: console's API             barrelman-ros2                      ROS 2 (DDS)
//!   /api/v1/socket  -- state, pictures --> console/socket -> feed -> convert --> topics
//!   /api/v1/requests <-- engage, stop ---- console/request <- calls <----------- services
//! ```
//!
//! The program is a client of the console, as a page is. `convert` is pure; `console` has the connections to
//! the program, `node` those to ROS 2. One thread runs all tasks; RustDDS has threads of its own.
//!
//! What must not be here: a decision about camera or boat, a copy of a rule of the console.
#![forbid(unsafe_code)]

pub mod cli;
pub mod settings;

pub mod notice;
pub mod program;

pub mod feed;
pub mod wall_clock;

pub mod calls;
pub mod stops;

pub mod console;
pub mod convert;
pub mod messages;
pub mod node;

#[cfg(test)]
mod test_states;
