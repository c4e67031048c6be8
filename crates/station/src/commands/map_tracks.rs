//! The tracks of a recording for maps: the boat and the marks with their times, as GeoJSON (RFC 7946), KML
//! 2.2 with `gx:Track`, and GPX 1.1.

use std::io::Write;

use anyhow::{Result, bail};
use barrelman_trial::records::{RecordedOutcome, RecordingStart};
use barrelman_vocab::earth::GeoPoint;
use barrelman_vocab::{MarkKind, Timestamp};
use quick_xml::Writer;
use serde_json::{Value, json};

/// Shortest time between two points of a track, seconds.
const INTERVAL_S: f64 = 0.5;

/// A format of the tracks.
#[derive(Debug, Clone, Copy)]
pub(super) enum MapFormat {
    /// GeoJSON.
    Geojson,
    /// KML, for Google Earth and others.
    Kml,
    /// GPX, for GPS devices and others.
    Gpx,
}

impl MapFormat {
    /// The name of the file.
    pub(super) const fn file(self) -> &'static str {
        match self {
            Self::Geojson => "tracks.geojson",
            Self::Kml => "tracks.kml",
            Self::Gpx => "tracks.gpx",
        }
    }
}

/// A place at a time.
#[derive(Debug, Clone, Copy)]
struct Fix {
    at: jiff::Timestamp,
    place: GeoPoint,
}

impl Fix {
    fn latitude(&self) -> f64 {
        self.place.latitude.degrees()
    }

    fn longitude(&self) -> f64 {
        self.place.longitude.degrees()
    }

    /// Longitude and latitude, as GeoJSON and KML have them.
    fn coordinates(&self) -> [f64; 2] {
        [self.longitude(), self.latitude()]
    }
}

/// Where something was, oldest place first.
#[derive(Debug)]
struct Track {
    name: String,
    /// `None`: the boat.
    mark: Option<MarkKind>,
    fixes: Vec<Fix>,
}

impl Track {
    /// Adds a place. Places that come too soon after the last one are left out.
    fn add(&mut self, fix: Fix) {
        let is_due = self
            .fixes
            .last()
            .is_none_or(|last| (fix.at - last.at).total(jiff::Unit::Second).is_ok_and(|s| s >= INTERVAL_S));
        if is_due {
            self.fixes.push(fix);
        }
    }
}

/// The tracks of a recording.
#[derive(Debug, Default)]
pub(super) struct Tracks {
    /// When the recording's clock began, nanoseconds since 1970.
    began_unix_ns: u64,
    tracks: Vec<Track>,
}

impl Tracks {
    /// The recording begins.
    pub(super) const fn begin(&mut self, start: &RecordingStart) {
        self.began_unix_ns = start.unix_ns;
    }

    /// Adds where boat and marks were at a step.
    pub(super) fn add(&mut self, outcome: &RecordedOutcome) {
        let (Some(vessel), Some(at)) = (&outcome.vessel, self.time_of(outcome.at)) else { return };
        if let Some(place) = vessel.boat_on_earth {
            self.track("boat".to_owned(), None).add(Fix { at, place });
        }
        for mark in &vessel.marks {
            if let Some(place) = mark.on_earth {
                let name = format!("{} {}", mark.kind.key(), mark.id);
                self.track(name, Some(mark.kind)).add(Fix { at, place });
            }
        }
    }

    fn time_of(&self, at: Timestamp) -> Option<jiff::Timestamp> {
        jiff::Timestamp::from_nanosecond(i128::from(self.began_unix_ns) + i128::from(at.as_nanos())).ok()
    }

    fn track(&mut self, name: String, mark: Option<MarkKind>) -> &mut Track {
        let index = self.tracks.iter().position(|track| track.name == name).unwrap_or(self.tracks.len());
        if index == self.tracks.len() {
            self.tracks.push(Track { name, mark, fixes: Vec::new() });
        }
        &mut self.tracks[index]
    }

    /// Fails where the recording held no place on Earth.
    ///
    /// # Errors
    /// What is missing, in words.
    pub(super) fn require_some(&self) -> Result<()> {
        if self.tracks.is_empty() {
            bail!(
                "it holds no latitude and longitude: the vehicle has to report its position and the direction of its \
                 camera from north, and the boat or a place has to be marked on the water"
            );
        }
        Ok(())
    }

    /// Writes the tracks.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn write(&self, format: MapFormat, mut file: impl Write) -> Result<()> {
        match format {
            MapFormat::Geojson => serde_json::to_writer_pretty(&mut file, &self.geojson())?,
            MapFormat::Kml => self.write_kml(&mut Writer::new_with_indent(&mut file, b' ', 1))?,
            MapFormat::Gpx => self.write_gpx(&mut Writer::new_with_indent(&mut file, b' ', 1))?,
        }
        Ok(writeln!(file)?)
    }

    fn geojson(&self) -> Value {
        let features: Vec<_> = self.tracks.iter().map(feature).collect();
        json!({ "type": "FeatureCollection", "features": features })
    }

    fn write_kml(&self, xml: &mut Writer<impl Write>) -> std::io::Result<()> {
        let names =
            [("xmlns", "http://www.opengis.net/kml/2.2"), ("xmlns:gx", "http://www.google.com/kml/ext/2.2")];
        xml.create_element("kml").with_attributes(names).write_inner_content(|xml| {
            xml.create_element("Document").write_inner_content(|xml| {
                for track in &self.tracks {
                    xml.create_element("Placemark").write_inner_content(|xml| {
                        text(xml, "name", &track.name)?;
                        xml.create_element("gx:Track").write_inner_content(|xml| {
                            track.fixes.iter().try_for_each(|fix| text(xml, "when", &fix.at.to_string()))?;
                            track.fixes.iter().try_for_each(|fix| {
                                text(
                                    xml,
                                    "gx:coord",
                                    &format!("{:.7} {:.7} 0", fix.longitude(), fix.latitude()),
                                )
                            })
                        })?;
                        Ok(())
                    })?;
                }
                Ok(())
            })?;
            Ok(())
        })?;
        Ok(())
    }

    /// Way-points first, then tracks, as the schema of GPX wants them.
    fn write_gpx(&self, xml: &mut Writer<impl Write>) -> std::io::Result<()> {
        let names =
            [("version", "1.1"), ("creator", "barrelman"), ("xmlns", "http://www.topografix.com/GPX/1/1")];
        xml.create_element("gpx").with_attributes(names).write_inner_content(|xml| {
            for (track, kind) in self.tracks.iter().filter_map(|track| Some((track, track.mark?))) {
                if let Some(fix) = track.fixes.last() {
                    point(xml, "wpt", fix, &[("name", &track.name), ("type", kind.key())])?;
                }
            }
            for track in &self.tracks {
                xml.create_element("trk").write_inner_content(|xml| {
                    text(xml, "name", &track.name)?;
                    xml.create_element("trkseg").write_inner_content(|xml| {
                        track.fixes.iter().try_for_each(|fix| point(xml, "trkpt", fix, &[]))
                    })?;
                    Ok(())
                })?;
            }
            Ok(())
        })?;
        Ok(())
    }
}

/// A track as a line, one place alone as a point. `coordTimes` are the times of the places, as the converters
/// from GPX and KML write them.
fn feature(track: &Track) -> Value {
    let coordinates: Vec<_> = track.fixes.iter().map(Fix::coordinates).collect();
    let times: Vec<_> = track.fixes.iter().map(|fix| fix.at.to_string()).collect();
    let geometry = match coordinates.as_slice() {
        [one] => json!({ "type": "Point", "coordinates": one }),
        line => json!({ "type": "LineString", "coordinates": line }),
    };
    let kind = track.mark.map_or("boat", MarkKind::key);
    let properties = json!({ "name": track.name, "kind": kind, "coordTimes": times });
    json!({ "type": "Feature", "geometry": geometry, "properties": properties })
}

fn text<W: Write>(xml: &mut Writer<W>, name: &str, content: &str) -> std::io::Result<()> {
    xml.create_element(name).write_text_content(quick_xml::events::BytesText::new(content))?;
    Ok(())
}

fn point<W: Write>(xml: &mut Writer<W>, name: &str, fix: &Fix, more: &[(&str, &str)]) -> std::io::Result<()> {
    let (latitude, longitude) = (format!("{:.7}", fix.latitude()), format!("{:.7}", fix.longitude()));
    let places = [("lat", latitude.as_str()), ("lon", longitude.as_str())];
    xml.create_element(name).with_attributes(places).write_inner_content(|xml| {
        text(xml, "time", &fix.at.to_string())?;
        more.iter().try_for_each(|(name, content)| text(xml, name, content))
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use barrelman_vocab::Angle;

    use super::*;

    fn tracks() -> Tracks {
        let at = |ms: i64| jiff::Timestamp::from_millisecond(1_790_000_000_000 + ms).unwrap();
        let fix = |ms, north: f64| {
            let place = GeoPoint {
                latitude: Angle::from_degrees(54.0 + north),
                longitude: Angle::from_degrees(-3.5),
            };
            Fix { at: at(ms), place }
        };
        let mut tracks = Tracks::default();
        let boat = tracks.track("boat".to_owned(), None);
        for (ms, north) in [(0, 0.0), (100, 0.1), (500, 0.001), (1000, 0.002)] {
            boat.add(fix(ms, north));
        }
        tracks.track("person 7".to_owned(), Some(MarkKind::Person)).add(fix(0, 0.01));
        tracks
    }

    fn written(format: MapFormat) -> String {
        let mut text = Vec::new();
        tracks().write(format, &mut text).unwrap();
        String::from_utf8(text).unwrap()
    }

    #[test]
    fn geojson_has_a_line_for_the_boat_and_a_point_for_a_mark_that_stays() {
        let found: Value = serde_json::from_str(&written(MapFormat::Geojson)).unwrap();
        let line = &found["features"][0];
        assert_eq!(line["geometry"]["type"], "LineString");
        assert_eq!(line["geometry"]["coordinates"].as_array().unwrap().len(), 3, "too soon is left out");
        assert_eq!(line["properties"]["coordTimes"][0], "2026-09-21T14:13:20Z");
        assert_eq!(found["features"][1]["geometry"]["type"], "Point");
        assert_eq!(found["features"][1]["properties"]["kind"], "person");
    }

    #[test]
    fn kml_has_as_many_times_as_places() {
        let text = written(MapFormat::Kml);
        let document = roxmltree::Document::parse(&text).unwrap();
        let count = |name: &str| document.descendants().filter(|node| node.tag_name().name() == name).count();
        assert_eq!((count("Placemark"), count("when"), count("coord")), (2, 4, 4));
        let first = document.descendants().find(|node| node.tag_name().name() == "coord").unwrap();
        assert_eq!(first.text(), Some("-3.5000000 54.0000000 0"));
    }

    #[test]
    fn gpx_has_the_marks_as_way_points_before_the_tracks() {
        let text = written(MapFormat::Gpx);
        let document = roxmltree::Document::parse(&text).unwrap();
        let names: Vec<_> = document.root_element().children().filter(|node| node.is_element()).collect();
        let order: Vec<_> = names.iter().map(|node| node.tag_name().name()).collect();
        assert_eq!(order, ["wpt", "trk", "trk"]);
        assert_eq!(names[0].attribute("lat"), Some("54.0100000"));
    }
}
