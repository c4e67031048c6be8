use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::{Angle, Timestamp};
use roxmltree::Document;

use super::super::scene::Motion;
use super::*;

fn origin(callsign: &str) -> Origin {
    Origin { run: "00ff".to_owned(), callsign: callsign.to_owned(), vehicle: "fotokite-sigma".to_owned() }
}

fn times() -> Times {
    let sent = jiff::Timestamp::from_millisecond(1_790_000_000_250).unwrap();
    Times { sent, known: sent - jiff::SignedDuration::from_millis(250) }
}

fn at_sea(subject: Subject) -> Located {
    let place = GeoPoint { latitude: Angle::from_degrees(-33.85), longitude: Angle::from_degrees(151.25) };
    Located { subject, at: Timestamp::ZERO, place, std_dev_m: Some(1.54), motion: Motion::default() }
}

fn written(located: &Located, callsign: &str) -> String {
    String::from_utf8(event(located, &origin(callsign), times()).unwrap()).unwrap()
}

/// An attribute of the only element with this name; `None`: it has none, or there is no such element.
fn attribute(text: &str, element: &str, name: &str) -> Option<String> {
    let document = Document::parse(text).unwrap();
    let found = document.descendants().find(|node| node.tag_name().name() == element)?;
    found.attribute(name).map(ToOwned::to_owned)
}

const CAMERA: Subject = Subject::Camera { height_m: Some(12.04) };

fn mark(kind: MarkKind) -> Subject {
    Subject::Mark { kind, id: 7 }
}

#[test]
fn an_event_says_what_is_where_and_until_when() {
    let boat = Located {
        motion: Motion { speed_m_per_s: Some(2.5), course: Some(Angle::from_degrees(-10.0)) },
        ..at_sea(Subject::Boat)
    };
    let expected = concat!(
        r#"<?xml version="1.0" encoding="UTF-8" standalone="yes"?>"#,
        r#"<event version="2.0" uid="barrelman-00ff-boat" type="a-f-S-C-U" how="m-i" "#,
        r#"time="2026-09-21T14:13:20.250Z" start="2026-09-21T14:13:20.000Z" stale="2026-09-21T14:13:26.000Z">"#,
        r#"<point lat="-33.8500000" lon="151.2500000" hae="9999999.0" ce="1.5" le="9999999.0"/>"#,
        r#"<detail><contact callsign="Barrelman boat"/><track speed="2.50" course="350.0"/>"#,
        "<remarks>Seen by the camera of fotokite-sigma; ce is the error of the line of sight, without those of ",
        "the camera&apos;s place and direction</remarks></detail></event>",
    );
    assert_eq!(written(&boat, "Barrelman"), expected);
}

#[test]
fn what_is_not_known_is_said_or_left_out() {
    let camera = Located { std_dev_m: None, ..at_sea(CAMERA) };
    let text = written(&camera, "Barrelman");
    for name in ["hae", "ce", "le"] {
        assert_eq!(attribute(&text, "point", name).as_deref(), Some("9999999.0"), "{name}");
    }
    assert!(!text.contains("<track"), "{text}");
    assert!(text.contains("Reported by fotokite-sigma, 12.0 m above the place of its start"), "{text}");
    let only_speed = Motion { speed_m_per_s: Some(0.0), course: None };
    let text = written(&Located { motion: only_speed, ..at_sea(Subject::Boat) }, "Barrelman");
    assert!(text.contains(r#"<track speed="0.00"/>"#), "{text}");
    let endless = Located { std_dev_m: Some(f64::INFINITY), ..at_sea(Subject::Boat) };
    assert_eq!(attribute(&written(&endless, ""), "point", "ce").as_deref(), Some("9999999.0"));
}

#[test]
fn each_subject_has_its_type_its_name_and_a_uid_of_its_own() {
    for (subject, kind, uid, callsign) in [
        (CAMERA, "a-f-A-M-H-Q", "barrelman-00ff-camera", "R1 camera"),
        (Subject::Boat, "a-f-S-C-U", "barrelman-00ff-boat", "R1 boat"),
        (mark(MarkKind::Person), "b-m-p-s-m", "barrelman-00ff-mark-7", "R1 person 7"),
        (mark(MarkKind::Place), "b-m-p-s-m", "barrelman-00ff-mark-7", "R1 place 7"),
        (mark(MarkKind::WayPoint), "b-m-p-w", "barrelman-00ff-mark-7", "R1 way-point 7"),
    ] {
        let text = written(&at_sea(subject), "R1");
        let found = [("event", "type"), ("event", "uid"), ("contact", "callsign")];
        let found = found.map(|(element, name)| attribute(&text, element, name).unwrap());
        assert_eq!(found, [kind, uid, callsign]);
    }
    let person = written(&at_sea(mark(MarkKind::Person)), "R1");
    assert_eq!(attribute(&person, "color", "argb").as_deref(), Some("-65536"));
    let icon = attribute(&person, "usericon", "iconsetpath");
    assert_eq!(icon.as_deref(), Some("COT_MAPPING_SPOTMAP/b-m-p-s-m/-65536"));
}

#[test]
fn a_callsign_with_characters_of_xml_arrives_as_it_is() {
    for callsign in [r#"R&D <"1"> 'x'"#, "]]>", "&amp;", "Küste 3 ⚓"] {
        let text = written(&at_sea(Subject::Boat), callsign);
        assert_eq!(attribute(&text, "contact", "callsign"), Some(format!("{callsign} boat")), "{text}");
    }
}
