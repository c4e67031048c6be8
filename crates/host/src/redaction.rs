//! Hides logins in texts that are shown, logged or recorded.

/// The text with the login of every address replaced by `***`, also in addresses that cannot be parsed. An address ends
/// at white space or a quotation mark.
pub fn without_logins(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("://") {
        shown += before;
        shown += "://";
        let end = after.find(|c: char| c.is_whitespace() || "\"'`".contains(c)).unwrap_or(after.len());
        // The @ in a plan of faults does not belong to a login.
        let address = after[..end].split("fault=").next().unwrap_or_default();
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
    shown + rest
}

#[cfg(test)]
mod tests {
    use super::*;

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
        check("no address: user@host", "no address: user@host");
    }
}
