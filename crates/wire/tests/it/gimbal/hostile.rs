//! Arbitrary bytes and requests: no panic, no rate above the limits, nothing but zeros after the end.

use barrelman_vocab::VehicleRates;
use barrelman_vocab::profile::OWN_RATE_LIMITS;
use barrelman_wire::mavlink::GimbalManager;
use barrelman_wire::mavlink::gimbal_manager::{GimbalManagerSettings, Habits};
use barrelman_wire::{LinkHistory, NextAction, Session as _};
use proptest::prelude::*;

use super::bench::{Bench, Sent, at, rates, sent};

#[derive(Debug, Clone)]
enum Event {
    Request(f64, f64),
    Bytes(Vec<u8>),
    TakeOver,
    TakeControl,
    Passes(bool, bool),
    Wait(u64),
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        4 => (-2.0..2.0, -2.0..2.0).prop_map(|(yaw, pitch)| Event::Request(yaw, pitch)),
        1 => Just(Event::Request(f64::NAN, f64::INFINITY)),
        2 => prop::collection::vec(any::<u8>(), 0..300).prop_map(Event::Bytes),
        1 => Just(Event::TakeOver),
        1 => Just(Event::TakeControl),
        1 => (any::<bool>(), any::<bool>()).prop_map(|(there, back)| Event::Passes(there, back)),
        4 => (1_u64..1_500).prop_map(Event::Wait),
    ]
}

proptest! {
    #[test]
    fn rates_keep_their_limits_and_end_with_zeros(
        is_px4 in any::<bool>(),
        events in prop::collection::vec(event(), 0..25),
    ) {
        let habits = if is_px4 { Habits::Px4 } else { Habits::ArduPilot };
        let mut bench = Bench::new(GimbalManagerSettings { habits, ..GimbalManagerSettings::default() });
        for event in events {
            match event {
                Event::Request(yaw, pitch) => bench.session.request(rates(yaw, pitch), None),
                Event::Bytes(bytes) => bench.session.received(&bytes, at(bench.now_ms), &mut |_| {}),
                Event::TakeOver => bench.take_over(),
                Event::TakeControl => bench.session.take_control(at(bench.now_ms)),
                Event::Passes(there, back) => bench.passes = (there, back),
                Event::Wait(ms) => bench.run(core::time::Duration::from_millis(ms)),
            }
            bench.step();
        }
        let end = bench.now_ms;
        bench.session.close(at(end));
        bench.session.request(rates(0.3, 0.3), None);
        bench.run(core::time::Duration::from_secs(4));
        for (ms, sent) in &bench.sent {
            if let Sent::Rates(_, _, yaw, pitch) = sent {
                let (pan, tilt) = (OWN_RATE_LIMITS.pan, OWN_RATE_LIMITS.tilt);
                prop_assert!(f64::from(yaw.abs()) <= pan.radians_per_second());
                prop_assert!(f64::from(pitch.abs()) <= tilt.radians_per_second());
            }
            prop_assert!(*ms < end || !sent.is_motion(), "motion after the end");
        }
        for step in bench.session.last_will(at(bench.now_ms)) {
            prop_assert!(sent(&step.packet).is_zeros());
        }
    }

    #[test]
    fn a_gimbal_manager_takes_any_bytes_and_stays_at_rest(
        reads in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..400), 0..8),
    ) {
        let mut manager = GimbalManager::boot(GimbalManagerSettings::default(), at(0));
        for bytes in reads {
            manager.receive(&bytes, at(5), &mut Vec::new(), |_, _| {});
        }
        prop_assert_eq!(manager.rates(), VehicleRates::REST);
    }
}

#[test]
fn a_session_after_a_motion_that_hears_nothing_sends_zeros_until_it_asks_for_another_port() {
    let mut bench = Bench::new(GimbalManagerSettings::default());
    bench.session.resume(LinkHistory { may_be_turning: true, ..LinkHistory::default() });
    bench.passes = (true, false);
    bench.run_until("the end", |bench| matches!(bench.last, NextAction::Reopen { .. }));
    assert_eq!(bench.now_ms, 10_005);
    let gap = bench.sent.iter().filter(|(_, sent)| sent.is_zeros()).map(|(ms, _)| *ms).collect::<Vec<_>>();
    assert!(gap.windows(2).all(|pair| pair[1] - pair[0] <= 250), "{gap:?}");
}
