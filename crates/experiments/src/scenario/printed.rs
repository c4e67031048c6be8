//! The text of a scenario with every key that its file may have: what `barrelman scenarios NAME` prints.
//!
//! A built-in file leaves out keys that have a default. The printed text holds them, each with its default
//! and its meaning; a key without a default is a comment. So the printed file is the same scenario as the
//! built-in one, and a start for another scenario. The built-in text itself stays as it is: its hash
//! identifies campaigns.

use std::collections::BTreeSet;

use barrelman_sim::sea::SeaState;
use toml::Table;

/// A key that a file may leave out: section, key, what the key is set to, and what it means. `None`: the key
/// has no default, and the example stands in a comment.
struct OptionalKey {
    section: &'static str,
    key: &'static str,
    default: Option<&'static str>,
    example: &'static str,
    meaning: &'static str,
}

const fn with_default(
    section: &'static str,
    key: &'static str,
    default: &'static str,
    meaning: &'static str,
) -> OptionalKey {
    OptionalKey { section, key, default: Some(default), example: "", meaning }
}

const fn without_default(
    section: &'static str,
    key: &'static str,
    example: &'static str,
    meaning: &'static str,
) -> OptionalKey {
    OptionalKey { section, key, default: None, example, meaning }
}

/// The keys that a file may leave out, in the order of their sections.
const OPTIONAL: [OptionalKey; 39] = [
    without_default(
        "camera",
        "frame",
        "[640, 480]",
        "Frame around the picture, pixels: bars fill the rest. Without it, the picture's size.",
    ),
    with_default(
        "camera",
        "barrel",
        "0.0",
        "Barrel distortion k of r_pinhole = r (1 + k r^2), r in focal lengths.",
    ),
    with_default(
        "camera",
        "rolling_shutter_s",
        "0.0",
        "From the readout of the first row to that of the last, seconds.",
    ),
    with_default("camera", "latency_jitter_s", "0.0", "Random addition to the latency, seconds."),
    with_default(
        "camera",
        "first_view_rad",
        "[0.0, 0.0]",
        "Mean error of the first view, pan and tilt, radians.",
    ),
    without_default("pan", "stops_deg", "[-170, 170]", "End stops, degrees. Without them, none."),
    without_default(
        "pan",
        "acceleration_rad_per_s2",
        "0.8",
        "Maximum acceleration, rad/s2. Without it, only the lag limits it.",
    ),
    with_default("pan", "dead_band_rad_per_s", "0.0", "A smaller rate does not move the axis, rad/s."),
    without_default("tilt", "stops_deg", "[-90, 10]", "End stops, degrees. Without them, none."),
    without_default(
        "tilt",
        "acceleration_rad_per_s2",
        "2.0",
        "Maximum acceleration, rad/s2. Without it, only the lag limits it.",
    ),
    with_default("tilt", "dead_band_rad_per_s", "0.0", "A smaller rate does not move the axis, rad/s."),
    without_default(
        "drawn",
        "cross_talk",
        "[-0.03, 0.03]",
        "Share of an axis's rate that also turns the other. Without it, none.",
    ),
    without_default(
        "drawn",
        "droop_deg_per_s",
        "[0.0, 0.1]",
        "Rate at which the tilt sinks, degrees per second. Without it, none.",
    ),
    without_default("drawn.pan", "gain", "[0.9, 1.1]", "Actual rate over commanded rate. Without it, 1."),
    without_default("drawn.tilt", "gain", "[0.9, 1.1]", "Actual rate over commanded rate. Without it, 1."),
    without_default(
        "boat",
        "path",
        "\"arena1\"",
        "A built-in path (arena1 or arena2) instead of way_points.",
    ),
    without_default(
        "boat",
        "way_points",
        "[[0, 20], [8, 30]]",
        "Way-points, metres, instead of a built-in path.",
    ),
    with_default(
        "boat",
        "steering",
        "\"jet\"",
        "What steers: jet (the nozzle), or jet-and-rudder, which steers a coasting boat, too.",
    ),
    without_default(
        "target",
        "path",
        "\"arena1\"",
        "A built-in path (arena1 or arena2) instead of way_points.",
    ),
    without_default(
        "target",
        "way_points",
        "[[0, 2], [1, 3]]",
        "Way-points, metres, instead of a built-in path.",
    ),
    without_default(
        "target",
        "start_m",
        "[0, 1]",
        "A way-point before the first of the path. Without it, the path starts with its first.",
    ),
    with_default("target", "breadth", "1.0", "Additional scale of x."),
    with_default("target", "weave_rad", "0.0", "Standard deviation of the weaving of the heading, radians."),
    with_default("target", "weave_time_s", "1.0", "Time constant of the weaving, seconds."),
    with_default(
        "target",
        "arrival_m",
        "0.0",
        "Distance before the end of the path over which it comes to rest, metres.",
    ),
    with_default(
        "target",
        "corner_pauses",
        "0.0",
        "Share of the path's corners with an additional pause, 0 to 1.",
    ),
    with_default(
        "target",
        "leg_rhythm",
        "0.0",
        "Reduction of the speed at both ends of each leg, a share from 0 to 1.",
    ),
    with_default(
        "target",
        "range_exponent",
        "0.0",
        "Exponent of the distance from the camera in the speed, 0 to 1.",
    ),
    with_default(
        "sensing",
        "noise_time_s",
        "0.0",
        "Time constant of the noise, seconds; 0: independent from picture to picture.",
    ),
    without_default(
        "sensing",
        "heading_noise_deg",
        "8.0",
        "Deviation of the bow's direction in the picture, degrees. Without it, the direction is not measured.",
    ),
    without_default(
        "sensing",
        "clamped_at_px",
        "[316, 177]",
        "Limits of |x| and |y|, pixels: a target beyond is reported there. Without them it is lost.",
    ),
    with_default(
        "object",
        "jitter_m",
        "0.0",
        "Standard deviation of the position from trial to trial, metres.",
    ),
    with_default("object", "heading_deg", "0.0", "Heading, degrees: 0 along x, anticlockwise."),
    with_default("object", "velocity_m_per_s", "[0.0, 0.0]", "Velocity along x and y, m/s."),
    without_default(
        "object",
        "turns_after_s",
        "10",
        "Time after which it reverses its velocity, again and again, seconds. Without it, never.",
    ),
    with_default(
        "object",
        "drifts",
        "false",
        "Whether it drifts with the current, the waves and a little with the wind.",
    ),
    without_default("object", "size_m", "[12, 2]", "Length and breadth of a pier, metres."),
    with_default("water", "current_m_per_s", "[0.0, 0.0]", "Steady current along x and y, m/s."),
    // The wind has a default that depends on the sea: see `wind_of`.
    without_default(
        "water",
        "wind_m_per_s",
        "",
        "Mean wind, m/s. Without it, the wind that raises this sea.",
    ),
];

/// Sections that a file may leave out, as comments for its end.
const LOSS: &str = "
# A bad radio link: pictures are lost or frozen. Without this section none are.
# [camera.loss]
# to_bad = 0.002   # probability per picture that a good link becomes bad
# to_good = 0.25   # and that a bad one becomes good
# spoilt = 0.7     # share of a bad link's pictures that are lost or frozen
# frozen = 0.3     # share of these that repeat the picture before
";
const ZOOM: &str = "
# A zoom. camera.focal_px is that of the widest view. Without this section the camera has none.
# [camera.zoom]
# ratio = 8.0         # focal length of the closest view over that of the widest
# limit_per_s = 0.3   # largest change of the focal length's logarithm in a second
# dead_time_s = 0.2   # from a command to its effect in the picture
";
const WATER: &str = "
# Water with waves. Without this section the ground is the laboratory's floor.
# [water]
# sea_state = 1          # 0 (glassy) to 4 (moderate)
# wind_m_per_s = 2.0     # without it, the wind that raises this sea
# wind_towards_deg = 200 # where it blows to: 0 along x, anticlockwise
# current_m_per_s = [0.0, 0.0] # steady current along x and y
";
const BOAT: &str = "
# A scenario has a moved [target] or a driven [boat]: `barrelman scenarios open`
# shows every key of [boat].
";
const TARGET: &str = "
# A scenario has a driven [boat] or a moved [target]: `barrelman scenarios lab1`
# shows every key of [target].
";
const OBJECT: &str = "
# Things beside the target: kind buoy, life-jacket, swimmer, red-craft, pier or
# shore. `barrelman scenarios distractors` and `pier` show some.
# [[object]]
# kind = \"buoy\"
# at = [4, 30]
";

/// The text of a scenario's file, completed. A text that is no TOML stays as it is.
pub fn complete(text: &str) -> String {
    let Ok(table) = text.parse::<Table>() else { return text.to_owned() };
    let sections = Sections::of(text);
    let mut out: Vec<String> = Vec::new();
    for (index, line) in text.lines().enumerate() {
        out.push(line.to_owned());
        for (section, last) in &sections.ends {
            if *last == index {
                let missing = OPTIONAL.iter().filter(|optional| optional.section == section);
                out.extend(missing.flat_map(|optional| lines_of(optional, &table)));
            }
        }
    }
    let mut completed = out.join("\n") + "\n";
    let has = |path: &str| find(&table, path).is_some();
    for (path, words) in [
        ("camera.loss", LOSS),
        ("camera.zoom", ZOOM),
        ("water", WATER),
        ("boat", BOAT),
        ("target", TARGET),
        ("object", OBJECT),
    ] {
        // A scenario without a boat has a target.
        if !has(path) {
            completed += words;
        }
    }
    completed
}

/// The lines of a key that a file leaves out; none where the file has it.
fn lines_of(optional: &OptionalKey, table: &Table) -> Vec<String> {
    let OptionalKey { section, key, default, example, meaning } = optional;
    let Some(found) = find(table, section) else { return Vec::new() };
    if found.contains_key(*key) {
        return Vec::new();
    }
    let comment = format!("# {meaning}");
    if (*section, *key) == ("water", "wind_m_per_s") {
        return wind_of(found).map_or_else(Vec::new, |wind| vec![comment, format!("{key} = {wind}")]);
    }
    match default {
        Some(default) => vec![comment, format!("{key} = {default}")],
        None => vec![comment, format!("# {key} = {example}")],
    }
}

/// The wind that raises the sea of `[water]`, m/s.
fn wind_of(water: &Table) -> Option<String> {
    let state = SeaState::new(u8::try_from(water.get("sea_state")?.as_integer()?).ok()?)?;
    Some(format!("{:?}", state.wind_mps()))
}

/// A section by its path; of several objects the first.
fn find<'t>(table: &'t Table, path: &str) -> Option<&'t Table> {
    path.split('.').try_fold(table, |table, name| {
        let value = table.get(name)?;
        value.as_table().or_else(|| value.as_array()?.first()?.as_table())
    })
}

/// Where the sections of a text end.
struct Sections {
    /// The path of each section, and the index of its last line with a value.
    ends: Vec<(String, usize)>,
}

impl Sections {
    fn of(text: &str) -> Self {
        let (mut ends, mut seen) = (Vec::new(), BTreeSet::new());
        let mut open: Option<(String, usize)> = None;
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if let Some(name) = header_of(line) {
                ends.extend(open.take());
                // Of several objects the first is completed.
                open = seen.insert(name.to_owned()).then(|| (name.to_owned(), index));
            } else if !line.is_empty()
                && !line.starts_with('#')
                && let Some((_, last)) = &mut open
            {
                *last = index;
            }
        }
        ends.extend(open);
        Self { ends }
    }
}

/// The path in a section's header; `None` for any other line.
fn header_of(line: &str) -> Option<&str> {
    let inner = line.strip_prefix('[')?;
    let inner = inner.strip_prefix('[').unwrap_or(inner);
    let name = inner.split(']').next()?.trim();
    let is_path = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "._-".contains(c));
    is_path.then_some(name)
}
