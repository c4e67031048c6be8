//! Options of the console, for `run` and `demo`.

use std::net::SocketAddr;
use std::path::PathBuf;

use barrelman_console_server::OnConsoleLost;
use clap::Args;

use super::values::parse_listen;

/// Options of the console.
#[derive(Debug, Clone, Args, Default)]
pub struct ConsoleOptions {
    /// Address of the console; default: 127.0.0.1:8480, or the next free port.
    #[arg(long, value_name = "ADDR", value_parser = parse_listen)]
    pub listen: Option<SocketAddr>,
    /// File with the console's tokens, two lines: control, watch; where it is missing, tokens are made and kept in it. Without this
    /// option, tokens are made for this run and printed as links.
    #[arg(long, value_name = "FILE")]
    pub console_token_file: Option<PathBuf>,
    /// What happens when the controlling page is gone (closed for 2 s, or silent for 3 s): the camera goes on, or stops.
    #[arg(long, value_enum, value_name = "WHAT")]
    pub on_console_lost: Option<OnConsoleLost>,
}
