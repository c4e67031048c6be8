//! Where the console is: links with their tokens, and QR codes of them on a terminal. Tokens that last longer than the program,
//! those of a file, are not printed: an output may be kept in a log.

use std::io::{IsTerminal as _, Write as _, stdout};
use std::net::{IpAddr, SocketAddr};
use std::path::Path;

use anyhow::Result;
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;

use super::access::Tokens;
use super::links_file::{self, ServedConsole};

/// Prints the links of a console. Scripts wait for the first line, which ends with the control link, or with the page's
/// address where there are no tokens to print.
///
/// # Errors
/// If the standard output cannot be written.
pub(super) fn announce(
    address: SocketAddr,
    tokens: Option<&Tokens>,
    token_file: Option<&Path>,
) -> Result<()> {
    let mut out = stdout();
    let Some(tokens) = tokens.filter(|_| token_file.is_none()) else {
        writeln!(out, "{}", address_lines(address, token_file))?;
        return Ok(out.flush()?);
    };
    let host = reachable(address);
    let (control, watch) = (link(host, &tokens.control), link(host, &tokens.watch));
    writeln!(out, "console, control: {control}\nconsole, watch only: {watch}")?;
    if out.is_terminal() && !host.ip().is_loopback() {
        for (what, link) in [("control", &control), ("watch only", &watch)] {
            if let Some(code) = qr_code(link) {
                writeln!(out, "\n{what}:\n{code}")?;
            }
        }
    }
    Ok(out.flush()?)
}

/// Prints the links of the console that is served with this links file, and a QR code of the one for control where another
/// device can open it.
///
/// # Errors
/// If no such console is served, the file may not be read, or the standard output not be written.
pub fn print_served(links_file: &Path) -> Result<()> {
    let ServedConsole { address, tokens } = links_file::read(links_file)?;
    let mut out = stdout();
    write!(out, "{}", served_lines(reachable(address), &tokens))?;
    Ok(out.flush()?)
}

fn served_lines(host: SocketAddr, tokens: &Tokens) -> String {
    let (control, watch) = (link(host, &tokens.control), link(host, &tokens.watch));
    let links = format!("control: {control}\nwatch only: {watch}\n");
    if host.ip().is_loopback() {
        let port = host.port();
        return format!(
            "{links}\nThe console listens on this computer alone. From another one: `ssh -L {port}:{host} COMPUTER`, and the link as it \
             is; or set console.listen in the configuration.\n"
        );
    }
    match qr_code(&control) {
        Some(code) => format!("{links}\ncontrol:\n{code}\n"),
        None => links,
    }
}

/// A QR code for a terminal; `None` for a text that is too long.
fn qr_code(text: &str) -> Option<String> {
    QrCode::new(text.as_bytes()).ok().map(|code| code.render::<Dense1x2>().quiet_zone(true).build())
}

/// The page's address, and where its tokens are.
fn address_lines(address: SocketAddr, token_file: Option<&Path>) -> String {
    match token_file {
        Some(file) => format!(
            "console: http://{}/\nthe page asks for a token: line 1 of {} for control, line 2 to watch",
            reachable(address),
            file.display()
        ),
        None => format!("console: http://{address}/"),
    }
}

/// The address of a page for control, with its token where there is one.
pub(super) fn link_for_control(address: SocketAddr, tokens: Option<&Tokens>) -> String {
    match tokens {
        Some(tokens) => link(reachable(address), &tokens.control),
        None => format!("http://{}/", reachable(address)),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_carries_its_token_where_no_server_and_no_log_sees_it() {
        for (address, expected) in [
            ("127.0.0.1:8480", "http://127.0.0.1:8480/#token=abc"),
            ("192.168.1.7:80", "http://192.168.1.7:80/#token=abc"),
            ("[::1]:8480", "http://[::1]:8480/#token=abc"),
        ] {
            assert_eq!(link(address.parse().unwrap(), "abc"), expected);
        }
    }

    #[test]
    fn tokens_of_a_file_are_not_printed_but_their_place_is() {
        let address = "127.0.0.1:8480".parse().unwrap();
        let lines = address_lines(address, Some(Path::new("/etc/barrelman/tokens")));
        let [first, second] = lines.lines().collect::<Vec<_>>()[..] else { panic!("{lines}") };
        assert_eq!(first, "console: http://127.0.0.1:8480/");
        assert!(second.contains("line 1 of /etc/barrelman/tokens for control"), "{second}");
        assert_eq!(address_lines(address, None), "console: http://127.0.0.1:8480/");
    }

    #[test]
    fn links_of_a_served_console_have_a_qr_code_where_another_device_can_open_them() {
        let tokens =
            Tokens { control: "control-0123456789".to_owned(), watch: "watch-0123456789".to_owned() };
        let lines = |host: &str| served_lines(host.parse().unwrap(), &tokens);
        for host in ["192.168.1.7:8480", "127.0.0.1:8480"] {
            for link in ["control: http://HOST/#token=control-", "watch only: http://HOST/#token=watch-"] {
                assert!(lines(host).contains(&link.replace("HOST", host)), "{}", lines(host));
            }
        }
        let code = qr_code("http://192.168.1.7:8480/#token=control-0123456789").unwrap();
        assert!(lines("192.168.1.7:8480").contains(&code));
        let local = lines("127.0.0.1:8480");
        assert!(!local.contains('█') && local.contains("ssh -L 8480:127.0.0.1:8480"), "{local}");
    }

    #[test]
    fn an_address_of_one_interface_is_shown_as_it_is() {
        for address in ["127.0.0.1:8480", "192.168.1.7:8481", "[::1]:8480"] {
            let address = address.parse().unwrap();
            assert_eq!(reachable(address), address);
        }
    }
}
