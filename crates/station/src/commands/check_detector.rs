//! `barrelman check` of the detector's model.

use super::check_result::{CheckResult, Verdict};
use crate::config::detector::DetectorConfig;
use crate::detector::DetectorSetup;

/// Loads the model, and tries it on an empty picture.
pub(super) fn check_detector(config: &DetectorConfig) -> CheckResult {
    let subject = format!("detector {}", config.model.display());
    match DetectorSetup::load(config) {
        Ok(setup) => CheckResult::new(subject, Verdict::Ok, format!("usable, finds {}", setup.classes())),
        Err(error) => CheckResult::new(subject, Verdict::Failed, format!("{error:#}")),
    }
}
