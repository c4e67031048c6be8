//! `barrelman check` of where the annotated video is served.

use super::check_result::{CheckResult, Verdict};
use crate::share::{ShareAddress, listen};

/// Checks whether the address can be listened on. The socket is closed at once.
pub(super) fn check_share(address: &ShareAddress) -> CheckResult {
    let subject = format!("share {address}");
    match listen(address) {
        Ok(_) if address.is_loopback() => {
            CheckResult::new(subject, Verdict::Ok, "can be listened on, by programs of this machine")
        }
        Ok(_) => {
            let details =
                "can be listened on; readers need the console's watch token, and the video is not encrypted";
            CheckResult::new(subject, Verdict::Ok, details)
        }
        Err(error) => CheckResult::new(subject, Verdict::Failed, format!("{error:#}")),
    }
}
