//! The operator's console: a web page and an interface for programs, served by the program itself.
//!
//! ```text
//!                 +--- routes: page files, /api/v1/..., /metrics, /healthz
//! thread console -+--- sockets: one task each; snapshots, events, answers, video
//!                 |       Snapshot <- watch   EventLog <- broadcast   VideoRelay <- broadcast
//!                 +--- requests -> seats (who controls?) -> Gateway -> loop
//! ```
//! The server reads what the loop publishes and submits requests to the gateway. Nothing here decides about
//! the camera or can delay the loop: each queue is bounded, and a reader that is slow loses frames.
//!
//! Off loopback the connections are encrypted ([`https`]). What a request must pass: [`guard`] (host,
//! origin), [`access`] (token), [`seats`] (control). A stop needs a token of either kind, and nothing else.

pub mod server;
mod shared;

mod library;
mod map;
mod routes;
mod socket;
mod token_door;
mod upgrade;

pub mod access;
mod admission;
mod entrance;
mod frame_counter;
mod guard;
mod https;
mod in_flight;
mod limited_stream;
mod limits;
mod on_lost;
mod origin;
mod places;
mod seats;
mod session_time;
mod settings;
mod tokens;

pub mod api;
mod files;
mod left_moving;
mod manual;
mod metrics;
mod requests;
mod states;
mod status;
mod track_status;
mod vessel_status;

mod newest_picture;
mod picker;
mod picture_answer;
mod pictures;
mod video_relay;

mod issued_links;
mod link_routes;
mod links;
mod links_file;

pub mod operator;
pub mod snapshot;

#[cfg(test)]
mod in_memory;
#[cfg(test)]
mod test_scenes;

pub use https::CertificateFiles;
pub use left_moving::LeftMoving;
pub use library::Library;
pub use links::print_served;
pub use map::Map;
pub use on_lost::OnConsoleLost;
pub use picker::{AfterPicking, pick};
pub use pictures::PictureSlot;
pub use server::ConsoleServer;
pub use session_time::SessionTime;
pub use settings::{ConsoleAddress, ConsoleSettings, Encryption};
pub use shared::{ConsoleParts, SessionFacts, VideoOutlet};
pub use token_door::TokenDoor;
pub use tokens::{KeptTokens, TokensInForce};
pub use video_relay::VideoRelay;
