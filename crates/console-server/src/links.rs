//! Where the console is: links with their tokens, and QR codes of them on a terminal. Tokens that last longer
//! than the program, those of a file, are not printed: an output may be kept in a log.

use std::io::{IsTerminal as _, Write as _, stdout};
use std::net::{IpAddr, SocketAddr};
use std::path::Path;

use anyhow::Result;
use qrcode::QrCode;
use qrcode::render::unicode::Dense1x2;

use super::https::Identity;
use super::links_file::{self, ServedConsole};
use super::origin::Origin;
use super::tokens::Tokens;

/// Prints the links of a console. Scripts wait for the first line, which ends with the control link, or with
/// the page's address where there are no tokens to print.
///
/// # Errors
/// If the standard output cannot be written.
pub(super) fn announce(
    origin: Origin,
    tokens: Option<&Tokens>,
    token_file: Option<&Path>,
    fingerprint: Option<&str>,
) -> Result<()> {
    let mut out = stdout();
    let at = reachable(origin);
    let trust = fingerprint.map_or_else(String::new, |fingerprint| trust_lines(at, fingerprint));
    let Some(tokens) = tokens.filter(|_| token_file.is_none()) else {
        write!(out, "{}{trust}", address_lines(origin, token_file))?;
        return Ok(out.flush()?);
    };
    let (control, watch) = (link(at, &tokens.control), link(at, &tokens.watch));
    write!(out, "console, control: {control}\nconsole, watch only: {watch}\n{trust}")?;
    if out.is_terminal() && !at.address.ip().is_loopback() {
        for (what, link) in [("control", &control), ("watch only", &watch)] {
            if let Some(code) = qr_code(link) {
                writeln!(out, "\n{what}:\n{code}")?;
            }
        }
    }
    Ok(out.flush()?)
}

/// Prints the links of the console that is served with this links file, and a QR code of the one for control
/// where another device can open it.
///
/// # Errors
/// If no such console is served, the file may not be read, or the standard output not be written.
pub fn print_served(links_file: &Path) -> Result<()> {
    let ServedConsole { origin, tokens, fingerprint } = links_file::read(links_file)?;
    let mut out = stdout();
    write!(out, "{}", served_lines(reachable(origin), &tokens, fingerprint.as_deref()))?;
    Ok(out.flush()?)
}

fn served_lines(at: Origin, tokens: &Tokens, fingerprint: Option<&str>) -> String {
    let (control, watch) = (link(at, &tokens.control), link(at, &tokens.watch));
    let trust = fingerprint.map_or_else(String::new, |fingerprint| trust_lines(at, fingerprint));
    let links = format!("control: {control}\nwatch only: {watch}\n{trust}");
    let host = at.address;
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
fn address_lines(origin: Origin, token_file: Option<&Path>) -> String {
    match token_file {
        Some(file) => format!(
            "console: {}/\nthe page asks for a token: line 1 of {} for control, line 2 to watch\n",
            reachable(origin),
            file.display()
        ),
        None => format!("console: {origin}/\n"),
    }
}

/// The SHA-256 of the console's own certificate authority, and what to do with it.
pub(super) fn trust_lines(origin: Origin, fingerprint: &str) -> String {
    let at = reachable(origin);
    format!(
        "console, SHA-256 of its certificate authority: {fingerprint}\n\
         On a device that warns, compare this SHA-256 with the one in the browser's view of the certificate, and go on. \
         So that it does not warn again, install the authority of {at}/trust.\n"
    )
}

/// The SHA-256 of the own certificate authority, if a console is served with it.
pub(super) fn fingerprint(https: Option<&Identity>) -> Option<&str> {
    Some(https?.authority()?.fingerprint.as_str())
}

/// The address of a page, with its token where there is one.
pub(super) fn link_to_page(origin: Origin, token: Option<&str>) -> String {
    match token {
        Some(token) => link(reachable(origin), token),
        None => format!("{}/", reachable(origin)),
    }
}

fn link(at: Origin, token: &str) -> String {
    format!("{at}/#token={token}")
}

/// The address by which another machine reaches a server that listens on all addresses of this machine.
fn reachable(origin: Origin) -> Origin {
    if !origin.address.ip().is_unspecified() {
        return origin;
    }
    // A UDP socket that is connected sends nothing, but knows the address of its interface.
    let own = std::net::UdpSocket::bind(("0.0.0.0", 0))
        .and_then(|socket| socket.connect(("192.0.2.1", 9)).map(|()| socket))
        .and_then(|socket| socket.local_addr());
    let ip = own.map_or(IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), |own| own.ip());
    Origin { address: SocketAddr::new(ip, origin.address.port()), ..origin }
}

#[cfg(test)]
mod tests {
    use super::super::origin::Scheme;
    use super::*;

    fn origin(scheme: Scheme, address: &str) -> Origin {
        Origin { scheme, address: address.parse().unwrap() }
    }

    #[test]
    fn a_link_carries_its_token_where_no_server_and_no_log_sees_it() {
        for (scheme, address, expected) in [
            (Scheme::Http, "127.0.0.1:8480", "http://127.0.0.1:8480/#token=abc"),
            (Scheme::Https, "192.168.1.7:443", "https://192.168.1.7:443/#token=abc"),
            (Scheme::Http, "[::1]:8480", "http://[::1]:8480/#token=abc"),
        ] {
            assert_eq!(link(origin(scheme, address), "abc"), expected);
        }
    }

    #[test]
    fn tokens_of_a_file_are_not_printed_but_their_place_is() {
        let address = origin(Scheme::Http, "127.0.0.1:8480");
        let lines = address_lines(address, Some(Path::new("/etc/barrelman/tokens")));
        let [first, second] = lines.lines().collect::<Vec<_>>()[..] else { panic!("{lines}") };
        assert_eq!(first, "console: http://127.0.0.1:8480/");
        assert!(second.contains("line 1 of /etc/barrelman/tokens for control"), "{second}");
        assert_eq!(address_lines(address, None), "console: http://127.0.0.1:8480/\n");
    }

    #[test]
    fn links_of_a_served_console_have_a_qr_code_where_another_device_can_open_them() {
        let tokens =
            Tokens { control: "control-0123456789".to_owned(), watch: "watch-0123456789".to_owned() };
        let fingerprint = |host: &str| (!host.starts_with("127")).then_some("AB:CD");
        let lines = |host: &str| served_lines(origin(Scheme::Https, host), &tokens, fingerprint(host));
        for host in ["192.168.1.7:8480", "127.0.0.1:8480"] {
            for link in ["control: https://HOST/#token=control-", "watch only: https://HOST/#token=watch-"] {
                assert!(lines(host).contains(&link.replace("HOST", host)), "{}", lines(host));
            }
        }
        let code = qr_code("https://192.168.1.7:8480/#token=control-0123456789").unwrap();
        assert!(lines("192.168.1.7:8480").contains(&code));
        for words in ["authority: AB:CD\n", "https://192.168.1.7:8480/trust"] {
            assert!(lines("192.168.1.7:8480").contains(words), "{}", lines("192.168.1.7:8480"));
        }
        let local = lines("127.0.0.1:8480");
        assert!(!local.contains('█') && local.contains("ssh -L 8480:127.0.0.1:8480"), "{local}");
    }

    #[test]
    fn an_address_of_one_interface_is_shown_as_it_is() {
        for address in ["127.0.0.1:8480", "192.168.1.7:8481", "[::1]:8480"] {
            let origin = origin(Scheme::Https, address);
            assert_eq!(reachable(origin), origin);
        }
    }
}
