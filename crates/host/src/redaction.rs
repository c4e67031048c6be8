//! Logins in addresses: hidden in texts that are shown, logged or recorded, and found where a password is not
//! percent-encoded.

/// How the name of a parameter ends whose value is a secret.
const SECRET_NAMES: [&str; 9] =
    ["password", "passwd", "passphrase", "pass", "pwd", "pw", "token", "secret", "key"];

/// The text with the login of every address, and with every secret parameter, replaced by `***`, also in
/// addresses that cannot be parsed. An address ends at white space or a quotation mark.
pub fn without_logins(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("://") {
        shown += before;
        shown += "://";
        let end = after.find(|c: char| c.is_whitespace() || "\"'`".contains(c)).unwrap_or(after.len());
        // The @ in a plan of faults does not belong to a login.
        let address = &after[..end];
        let address = fault_plan(address).map_or(address, |at| &address[..at]);
        let authority = address.split(['/', '?', '#']).next().unwrap_or_default();
        // A slash in a password ends the authority early: then the text up to the last @ is hidden.
        let hidden_to = if authority.contains('@') { authority.rfind('@') } else { address.rfind('@') };
        rest = match hidden_to {
            Some(at) => {
                shown += "***";
                &after[at..]
            }
            None => after,
        };
    }
    without_secret_values(&(shown + rest))
}

/// The text with the values of secret parameters replaced by `***`: `password=...` in the query or the path
/// of an address, `user-pw=...` in a pipeline.
fn without_secret_values(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('=') {
        let name = before.to_ascii_lowercase();
        shown += before;
        shown += "=";
        rest = after;
        if SECRET_NAMES.iter().any(|secret| name.ends_with(secret)) && !after.is_empty() {
            let (value, quote) = match after.chars().next() {
                Some(quote @ ('"' | '\'')) => (&after[1..], Some(quote)),
                _ => (after, None),
            };
            let is_end = |c: char| match quote {
                Some(quote) => c == quote,
                None => c.is_whitespace() || "&;\"'`".contains(c),
            };
            let end = value.find(is_end).unwrap_or(value.len());
            shown.extend(quote);
            shown += "***";
            rest = &value[end..];
        }
    }
    shown + rest
}

/// Whether an address has an @ elsewhere than once before its host. Where a password is not percent-encoded,
/// a part of it would be read as the host, or as the port, and would be looked up. The @ in a plan of faults
/// at the end is none of these.
pub fn has_stray_at(address: &str) -> bool {
    let rest = address.split_once("://").map_or(address, |(_, rest)| rest);
    let rest = fault_plan(rest).map_or(rest, |at| &rest[..at]);
    let (authority, path) = rest.split_at(rest.find(['/', '?', '#']).unwrap_or(rest.len()));
    path.contains('@') || authority.matches('@').count() > 1
}

/// Where the plan of faults of an address begins: `KIND@SECONDS`, and more of them behind commas. A part of a
/// password is none.
fn fault_plan(address: &str) -> Option<usize> {
    let begins = ["?fault=", "&fault="].into_iter().filter_map(|name| Some(address.find(name)? + name.len()));
    let at = begins.min()?;
    let is_fault = |text: &str| {
        text.split_once('@').is_none_or(|(kind, times)| {
            kind.bytes().all(|byte| byte.is_ascii_lowercase())
                && times.split('+').all(|time| time.trim_end_matches('s').parse::<f64>().is_ok())
        })
    };
    let plan = address[at..].split('&').next().unwrap_or_default();
    plan.split(',').all(is_fault).then_some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_at_that_is_not_the_one_before_the_host_is_found() {
        for text in [
            "rtsp://u:se@cret@h/x",
            "rtsp://u:se/cret@h/x",
            "rtsp://u:se?cret@h/x",
            "rtsp://u:se#cret@h/x",
            "rtsp://u:80/cret@h/x",
            "rtsp://u:80?fault=cret@h/x",
            "rtsp://u:80?fault=cret@10.0.0.1",
            "http://h/x@y",
            "tcp://u:p@h@i:1",
        ] {
            assert!(has_stray_at(text), "{text}");
        }
        for text in [
            "rtsp://u:secret@h/x",
            "rtsp://u:se%40cret@h:8554/x?y=1",
            "rtsp://u:se:cret@h/x",
            "rtsp://h/x?fault=stall@12.5s,drop@3+2",
            "tcp://h:1?fault=explode@3",
            "tcp://h:1",
        ] {
            assert!(!has_stray_at(text), "{text}");
        }
    }

    #[test]
    fn logins_are_hidden_in_any_text() {
        let check = |text: &str, shown: &str| assert_eq!(without_logins(text), shown);
        check("rtsp://cam/live", "rtsp://cam/live");
        check(
            "at tcp://u:secret@h:1, then rtsp://v:se/cret@cam/x now",
            "at tcp://***@h:1, then rtsp://***@cam/x now",
        );
        check("url = \"rtsp://u:secret@cam\" # mail@home", "url = \"rtsp://***@cam\" # mail@home");
        check("tcp://host?fault=stall@3", "tcp://host?fault=stall@3");
        check("tcp://u:12?fault=secret@host/x", "tcp://***@host/x");
        check("no address: user@host", "no address: user@host");
        check("srt://h:1?passphrase=se/cr?et&mode=caller", "srt://h:1?passphrase=***&mode=caller");
        check("rtsp://h/user=admin&PassWord=secret&channel=1", "rtsp://h/user=admin&PassWord=***&channel=1");
        check("http://u:p@h/x.cgi?user=a&pwd=secret now", "http://***@h/x.cgi?user=a&pwd=*** now");
        check("gst:rtspsrc user-pw=\"se cret\" ! x", "gst:rtspsrc user-pw=\"***\" ! x");
        check("gst:x user-pw=secret ! y key-int-max=3", "gst:x user-pw=*** ! y key-int-max=3");
        check("http://h?a=1&token=", "http://h?a=1&token=");
    }
}
