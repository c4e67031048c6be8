//! Events of Cursor on Target, version 2.0, as XML.
//!
//! An event says what is where until when. `ce` and `le` are standard deviations, metres, in the plane and of
//! the height above the ellipsoid (`hae`); [`UNKNOWN`] stands for what is not known. Types follow
//! MIL-STD-2525.

use std::io;
use std::io::Write;

use barrelman_vocab::MarkKind;
use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};

use super::scene::{Located, Subject};

/// What Cursor on Target writes for a height or an error that is not known.
const UNKNOWN: &str = "9999999.0";
/// A display shows what is older than this as stale: after the program has ended, or where events get lost.
const STALE_AFTER: jiff::SignedDuration = jiff::SignedDuration::from_secs(6);
/// Colours of marks: alpha, red, green and blue in one signed number, as ATAK has them.
const RED: i32 = -65_536;
const YELLOW: i32 = -256;
const WHITE: i32 = -1;

/// When an event is sent, and when its place was known.
#[derive(Debug, Clone, Copy)]
pub(super) struct Times {
    pub(super) sent: jiff::Timestamp,
    pub(super) known: jiff::Timestamp,
}

/// Who sends the events.
#[derive(Debug, Clone)]
pub(super) struct Origin {
    /// Names this run; no other run has it.
    pub(super) run: String,
    /// The names on the map begin with this.
    pub(super) callsign: String,
    /// The vehicle's name.
    pub(super) vehicle: String,
}

/// The event of something at a place.
///
/// # Errors
/// Never in practice: it is written to memory.
pub(super) fn event(located: &Located, origin: &Origin, times: Times) -> io::Result<Vec<u8>> {
    let mut xml = Writer::new(Vec::new());
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), Some("yes"))))?;
    let (kind, how) = kind_and_how(located.subject);
    let (uid, time) = (uid(located.subject, origin), |at: jiff::Timestamp| format!("{at:.3}"));
    let (sent, known, stale) = (time(times.sent), time(times.known), time(times.known + STALE_AFTER));
    let attributes = [
        ("version", "2.0"),
        ("uid", &uid),
        ("type", kind),
        ("how", how),
        ("time", &sent),
        ("start", &known),
        ("stale", &stale),
    ];
    xml.create_element("event").with_attributes(attributes).write_inner_content(|xml| {
        write_point(xml, located)?;
        xml.create_element("detail").write_inner_content(|xml| write_detail(xml, located, origin))?;
        Ok(())
    })?;
    Ok(xml.into_inner())
}

/// The type of an event, and how its place came about: by GPS, by measuring a picture, by a calculation from
/// what a person pointed at.
///
/// No mark is a `b-r-f-h-c`: that requests an evacuation, and displays raise an alarm.
const fn kind_and_how(subject: Subject) -> (&'static str, &'static str) {
    match subject {
        Subject::Camera { .. } => ("a-f-A-M-H-Q", "m-g"),
        Subject::Boat => ("a-f-S-C-U", "m-i"),
        Subject::Mark { kind: MarkKind::WayPoint, .. } => ("b-m-p-w", "h-c"),
        Subject::Mark {
            kind: MarkKind::Person | MarkKind::Place | MarkKind::Forbidden | MarkKind::Home,
            ..
        } => ("b-m-p-s-m", "h-c"),
    }
}

/// What identifies the subject on a display, as long as the run lasts.
fn uid(subject: Subject, Origin { run, .. }: &Origin) -> String {
    match subject {
        Subject::Camera { .. } => format!("barrelman-{run}-camera"),
        Subject::Boat => format!("barrelman-{run}-boat"),
        Subject::Mark { id, .. } => format!("barrelman-{run}-mark-{id}"),
    }
}

fn callsign(subject: Subject, Origin { callsign, .. }: &Origin) -> String {
    match subject {
        Subject::Camera { .. } => format!("{callsign} camera"),
        Subject::Boat => format!("{callsign} boat"),
        Subject::Mark { kind, id } => format!("{callsign} {} {id}", kind.key()),
    }
}

/// Where the place comes from.
fn remarks(subject: Subject, Origin { vehicle, .. }: &Origin) -> String {
    let alone = "ce is the error of the line of sight, without those of the camera's place and direction";
    match subject {
        Subject::Camera { height_m: Some(height_m) } => {
            format!("Reported by {vehicle}, {height_m:.1} m above the place of its start")
        }
        Subject::Camera { height_m: None } => format!("Reported by {vehicle}"),
        Subject::Boat => format!("Seen by the camera of {vehicle}; {alone}"),
        Subject::Mark { kind, .. } => {
            format!("{} marked by the operator in the picture of {vehicle}; {alone}", kind.key())
        }
    }
}

const fn colour(subject: Subject) -> Option<i32> {
    match subject {
        Subject::Camera { .. } | Subject::Boat => None,
        Subject::Mark { kind, .. } => Some(match kind {
            MarkKind::Person => RED,
            MarkKind::Forbidden => YELLOW,
            MarkKind::Place | MarkKind::WayPoint | MarkKind::Home => WHITE,
        }),
    }
}

fn write_point<W: Write>(xml: &mut Writer<W>, located: &Located) -> io::Result<()> {
    let latitude = format!("{:.7}", located.place.latitude.degrees());
    let longitude = format!("{:.7}", located.place.longitude.degrees());
    let error = located.std_dev_m.filter(|error| error.is_finite());
    let error = error.map_or_else(|| UNKNOWN.to_owned(), |error| format!("{error:.1}"));
    let attributes =
        [("lat", latitude.as_str()), ("lon", &longitude), ("hae", UNKNOWN), ("ce", &error), ("le", UNKNOWN)];
    xml.create_element("point").with_attributes(attributes).write_empty()?;
    Ok(())
}

fn write_detail<W: Write>(xml: &mut Writer<W>, located: &Located, origin: &Origin) -> io::Result<()> {
    let callsign = callsign(located.subject, origin);
    xml.create_element("contact").with_attribute(("callsign", callsign.as_str())).write_empty()?;
    let speed = located.motion.speed_m_per_s.map(|speed| format!("{speed:.2}"));
    let course = located.motion.course.map(|course| format!("{:.1}", course.degrees().rem_euclid(360.0)));
    let track = [("speed", speed), ("course", course)];
    let track: Vec<_> = track.iter().filter_map(|(name, value)| Some((*name, value.as_deref()?))).collect();
    if !track.is_empty() {
        xml.create_element("track").with_attributes(track).write_empty()?;
    }
    if let Some(colour) = colour(located.subject) {
        let (kind, _) = kind_and_how(located.subject);
        xml.create_element("color").with_attribute(("argb", colour.to_string().as_str())).write_empty()?;
        if kind == "b-m-p-s-m" {
            let icon = format!("COT_MAPPING_SPOTMAP/{kind}/{colour}");
            xml.create_element("usericon").with_attribute(("iconsetpath", icon.as_str())).write_empty()?;
        }
    }
    xml.create_element("remarks").write_text_content(BytesText::new(&remarks(located.subject, origin)))?;
    Ok(())
}

#[cfg(test)]
mod tests;
