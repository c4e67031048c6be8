//! Boat, camera and marks on the maps of TAK (ATAK, WinTAK, TAK servers), as events of Cursor on Target
//! (CoT).
//!
//! ```text
//! thread tak: newest snapshot -> scene -> cot (XML) -> sender (UDP) -> line (TCP, TLS)
//! ```
//! Once a second the thread sends an event for each subject whose latitude and longitude are known. It reads
//! the snapshot and requests nothing. What must not be here: a place that the program does not know, a log
//! line for each event that cannot be sent.

mod address;
mod cot;
mod line;
mod route;
mod scene;
mod send_log;
mod sender;
mod thread;

pub use address::{TakAddress, Transport};
pub use line::Encryption;
pub use route::TakRoute;
pub use sender::probe;
pub use thread::TakThread;

/// What the thread needs to know from the start.
#[derive(Debug, Clone)]
pub struct TakSetup {
    /// Where the events go, as it was given.
    pub address: TakAddress,
    /// How they go there.
    pub route: TakRoute,
    /// The names on the map begin with this.
    pub callsign: String,
    /// The vehicle's name, for the remarks.
    pub vehicle: String,
}
