//! A live run: threads, one queue of events, and the loop that steps the pilot.
//!
//! ```text
//! video thread ----frames--> Latest ------+
//!    \--units--> recorder                 |
//! link thread -----telemetry----------> events -> run_loop: Pilot::step -> link, recorder, overlay, status
//! terminal thread --keys, signals---------+
//! ```
//! [`session`] opens and closes the parts of a run. Only [`run_loop`] steps the pilot. The other threads make
//! no decisions.

pub mod session;

mod connections;
pub mod event;
pub mod run_loop;

mod new_drive;

pub mod calibration;
pub mod killed_together;
mod open_link;
mod open_vessel;
mod parts;
pub mod recording_folder;
mod recording_start;
pub mod sleep_inhibitor;
pub mod sortie_text;
pub mod source;
pub mod supervision;
mod track_video;
pub mod tracked_video;
mod video_sink;
mod video_states;

pub mod overlay_video;
pub mod recorder;
pub mod recording_sync;
pub mod status_line;
pub mod status_writer;
pub mod terminal;
pub mod threads;

pub mod faults;
pub mod foxglove_server;
mod inbox;
