//! Answers, messages and requests that no real vehicle or program sends: nothing panics, and what is sent
//! keeps the rules.

use std::time::Duration;

use barrelman_vocab::ZoomRate;
use barrelman_vocab::telemetry::Report;
use barrelman_wire::Session as _;
use barrelman_wire::fotokite_sigma::sigma::{Incoming, SigmaSettings, View};
use barrelman_wire::fotokite_sigma::{Call, FotokiteSigmaSession, Sigma};
use barrelman_wire::http::{HttpCall as _, Received};
use proptest::prelude::*;

use crate::sigma_conversation::{at, rates};

/// Bodies that look like answers, with numbers and names of any kind.
fn bodies() -> impl Strategy<Value = Vec<u8>> {
    let number = prop_oneof![
        any::<f64>().prop_map(|value| format!("{value:?}")),
        Just("null".to_owned()),
        Just("1e999".to_owned()),
        Just("\"x\"".to_owned()),
        (-400.0..400.0_f64).prop_map(|value| value.to_string()),
    ];
    let name = prop_oneof![
        Just("zoom"),
        Just("../../flight/control/takeoff"),
        Just(""),
        Just("Offline"),
        Just("Fatal")
    ];
    let texts = (proptest::collection::vec(number, 6), name).prop_map(|(n, name)| {
        format!(
            r#"{{"pan_speed_min":{},"pan_speed_max":{},"tilt_speed_min":{},"tilt_speed_max":{},"pan_ned":{},"tilt_ned":{},
                "fov_horizontal":{},"online_state":"{name}","flight_state":"{name}","kite_battery_level":{}}}"#,
            n[0], n[1], n[2], n[3], n[4], n[5], n[0], n[1]
        )
    });
    let streams = name_list();
    prop_oneof![
        6 => texts.prop_map(String::into_bytes),
        2 => streams.prop_map(String::into_bytes),
        1 => proptest::collection::vec(any::<u8>(), 0..60),
    ]
}

fn name_list() -> impl Strategy<Value = String> {
    proptest::collection::vec("[a-z./%]{0,12}", 0..4).prop_map(|names| {
        let streams: Vec<_> =
            names.iter().map(|name| format!(r#"{{"stream_id":"{name}","severity":"{name}"}}"#)).collect();
        format!("[{}]", streams.join(","))
    })
}

proptest! {
    #[test]
    fn no_answer_makes_a_session_break_the_rules(
        answers in proptest::collection::vec((prop_oneof![Just(200_u16), Just(201), Just(202), 100..600_u16], bodies()), 1..80),
        wanted in (-90.0..90.0, -90.0..90.0),
    ) {
        let mut session = FotokiteSigmaSession::open(None, ZoomRate::from_per_second(0.3), at(0));
        session.request(rates(wanted.0, wanted.1), Some(at(600_000)));
        let (mut now, mut out) = (at(0), Vec::new());
        let mut answers = answers.into_iter();
        let mut reports = Vec::new();
        for _ in 0..120 {
            session.poll(now, &mut out);
            now = now.plus(Duration::from_millis(40));
            for request in out.drain(..) {
                let path = request.call.path();
                prop_assert!(!path.contains("..") && !path.contains("flight/control"), "{path}");
                if let Call::Turn { speeds, .. } = &request.call {
                    prop_assert!(speeds.pan_deg_per_s().abs() <= wanted.0.abs() + 0.001);
                    prop_assert!(speeds.tilt_deg_per_s().abs() <= wanted.1.abs() + 0.001);
                }
                let Some((status, body)) = answers.next() else { continue };
                session.received(&Received::Message(body.clone()), now, &mut |report| reports.push(report.report));
                let answer = Received::Answer { id: request.id, status, body };
                session.received(&answer, now, &mut |report| reports.push(report.report));
            }
        }
        for report in reports {
            match report {
                Report::CameraTilt(angle) => prop_assert!(angle.degrees().abs() <= 180.001),
                Report::FieldOfView(angle) => prop_assert!((0.09..170.1).contains(&angle.degrees())),
                _ => {}
            }
        }
    }

    #[test]
    fn no_request_turns_the_vehicle_s_end_beyond_its_limits(
        requests in proptest::collection::vec((any::<bool>(), prop_oneof![
            Just("/v1/camera/control/rotate_with_speed".to_owned()),
            Just("/v1/handoff/control/request".to_owned()),
            "/[a-z0-9/._]{0,30}",
        ], bodies()), 1..40),
    ) {
        let mut sigma = Sigma::new(SigmaSettings::example());
        for (number, (is_post, path, body)) in requests.iter().enumerate() {
            let method = if *is_post { "POST" } else { "GET" };
            let request = Incoming { method, path, token: Some("token"), body };
            let now = at(100 * number as u64);
            let answer = sigma.answer(request, View::default(), now);
            prop_assert!((200..600).contains(&answer.status));
            prop_assert!(sigma.rates(now).yaw.radians_per_second().abs() <= 25.0_f64.to_radians());
        }
    }
}
