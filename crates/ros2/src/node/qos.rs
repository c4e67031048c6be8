//! Qualities of service, as the profiles of rmw have them.

use ros2_client::qos::{Durability, History, QosProfile, WhenFull};

/// `rmw_qos_profile_sensor_data`: what is lost is not sent again.
pub(super) const fn sensor_data() -> QosProfile {
    QosProfile::publisher_default().reliability_best_effort().history(History::KeepLast { depth: 5 })
}

/// `rmw_qos_profile_default`. A subscriber that does not keep up loses messages: nothing waits for it.
pub(super) const fn state() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .history(History::KeepLast { depth: 10 })
}

/// `rmw_qos_profile_services_default`.
pub(super) const fn service() -> QosProfile {
    state().durability(Durability::Volatile)
}
