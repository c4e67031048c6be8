//! Where the console is: links with their tokens, and QR codes of them on a terminal.

use std::io::{IsTerminal as _, Write as _, stdout};
use std::net::{IpAddr, SocketAddr};

use anyhow::Result;
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;

use super::access::Tokens;

/// Prints the links of a console. Scripts wait for the first line, which ends with the control link.
///
/// # Errors
/// If the standard output cannot be written.
pub(super) fn announce(address: SocketAddr, tokens: Option<&Tokens>) -> Result<()> {
    let mut out = stdout();
    let Some(tokens) = tokens else {
        writeln!(out, "console: http://{address}/")?;
        return Ok(out.flush()?);
    };
    let host = reachable(address);
    let (control, watch) = (link(host, &tokens.control), link(host, &tokens.watch));
    writeln!(out, "console, control: {control}\nconsole, watch only: {watch}")?;
    if out.is_terminal() && !host.ip().is_loopback() {
        for (what, link) in [("control", &control), ("watch only", &watch)] {
            if let Ok(code) = QrCode::new(link.as_bytes()) {
                let code = code.render::<Dense1x2>().quiet_zone(true).build();
                writeln!(out, "\n{what}:\n{code}")?;
            }
        }
    }
    Ok(out.flush()?)
}

fn link(host: SocketAddr, token: &str) -> String {
    format!("http://{host}/#token={token}")
}

/// The address by which another machine reaches a server that listens on all addresses of this machine.
fn reachable(address: SocketAddr) -> SocketAddr {
    if !address.ip().is_unspecified() {
        return address;
    }
    // A UDP socket that is connected sends nothing, but knows the address of its interface.
    let own = std::net::UdpSocket::bind(("0.0.0.0", 0))
        .and_then(|socket| socket.connect(("192.0.2.1", 9)).map(|()| socket))
        .and_then(|socket| socket.local_addr());
    let ip = own.map_or(IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), |own| own.ip());
    SocketAddr::new(ip, address.port())
}
