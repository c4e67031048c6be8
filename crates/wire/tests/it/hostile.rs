//! Arbitrary bytes: no panic and no motion.

use barrelman_vocab::Timestamp;
use barrelman_vocab::telemetry::LinkState;
use barrelman_wire::fotokite_pro::ground_station::{GroundStationSettings, StationState};
use barrelman_wire::fotokite_pro::{FotokiteProSession, GroundStation, SessionSettings};
use barrelman_wire::{Framing, Session as _};
use proptest::prelude::*;

proptest! {
    #[test]
    fn a_session_takes_any_bytes_at_any_time(
        reads in prop::collection::vec((prop::collection::vec(any::<u8>(), 0..80), 0_u64..900), 0..20),
    ) {
        let settings = SessionSettings::for_baud(Framing::CarriageReturns, 9_600);
        let mut session = FotokiteProSession::open(settings, Timestamp::ZERO);
        let (mut now_ms, mut out) = (0, Vec::new());
        for (bytes, wait_ms) in reads {
            now_ms += wait_ms;
            let now = Timestamp::from_nanos(now_ms * 1_000_000);
            session.received(&bytes, now, &mut |_| {});
            session.poll(now, &mut out);
        }
        prop_assert!(out.concat().len() < 20_000);
        prop_assert!(session.link_state() != LinkState::Closed);
    }

    #[test]
    fn a_station_takes_any_bytes_and_stays_at_rest_without_remote_control(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let mut station = GroundStation::boot(GroundStationSettings::default(), Timestamp::ZERO);
        let mut out = Vec::new();
        station.receive(&bytes, Timestamp::ZERO, &mut out, |_| {});
        if station.state() == StationState::Shell {
            prop_assert_eq!(station.rates(), Default::default());
        }
    }
}
