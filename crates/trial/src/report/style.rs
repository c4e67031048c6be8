//! Colours and strokes of figures: one palette, for light and dark screens.

use std::fmt::Write as _;

/// A colour of the palette: name, value in the light scheme, value in the dark scheme.
type Colour = (&'static str, &'static str, &'static str);

/// `track` is for the target's path, `out` for excursions, `region` for the boundary P = 1, `tilt` and `pan`
/// for commands.
const PALETTE: [Colour; 9] = [
    ("paper", "#fdfcf9", "#15191c"),
    ("ink", "#20272b", "#e8e5de"),
    ("muted", "#687177", "#9aa3a8"),
    ("hair", "#dedad1", "#31383d"),
    ("track", "#28607c", "#86bcd6"),
    ("out", "#c4431c", "#ff8d60"),
    ("region", "#2c7a58", "#74c69d"),
    ("tilt", "#75489a", "#c6a1e4"),
    ("pan", "#28607c", "#86bcd6"),
];

/// Style rules: selector and declarations. `%name` stands for a colour of the palette.
const RULES: [(&str, &str); 39] = [
    (".fig .sheet", "fill:%paper;stroke:none"),
    (
        ".fig text",
        "font-family:system-ui,-apple-system,'Segoe UI','Helvetica Neue',Arial,'DejaVu Sans',sans-serif;font-size:11px;fill:%ink",
    ),
    (".fig .tick", "fill:%muted"),
    (".fig .unit", "fill:%muted;font-size:10.5px"),
    (".fig .small", "font-size:9px"),
    (".fig .name", "font-weight:600"),
    (".fig .t-out", "fill:%out"),
    (".fig .t-region", "fill:%region"),
    (".fig .t-tilt", "fill:%tilt"),
    (".fig .t-pan", "fill:%pan"),
    (".fig .halo", "fill:none;stroke:%paper;stroke-width:3;stroke-linejoin:round"),
    (".fig path,.fig line", "fill:none;stroke-linecap:butt;stroke-linejoin:round"),
    (".fig .axis", "stroke:%muted;stroke-width:1"),
    (".fig .grid", "stroke:%hair;stroke-width:1"),
    (".fig .frame", "fill:none;stroke:%hair;stroke-width:1"),
    (".fig .margin", "fill:%hair;fill-opacity:.45;stroke:none"),
    (".fig .bound", "stroke:%region;stroke-width:1.3"),
    (".fig .region", "fill:%region;fill-opacity:.07;stroke:%region;stroke-width:1.3"),
    (".fig .sector", "stroke:%muted;stroke-width:1;stroke-dasharray:2 4"),
    (".fig .track", "stroke:%track;stroke-width:1.3"),
    (".fig .shadow", "stroke:%muted;stroke-width:1.1;stroke-dasharray:4 2.5"),
    (".fig .t-shadow", "fill:%muted"),
    (".fig .faint", "stroke-opacity:.55;stroke-width:1"),
    (".fig .out", "stroke:%out;stroke-width:1.6"),
    (".fig .over", "fill:%out;fill-opacity:.3;stroke:none"),
    (".fig .wash", "fill:%out;fill-opacity:.08;stroke:none"),
    (".fig .gap", "fill:%muted;fill-opacity:.16;stroke:none"),
    (".fig .h", "stroke:%out;stroke-width:1"),
    (".fig .b", "stroke:%out;stroke-width:3.2"),
    (".fig .open", "stroke-dasharray:4 2.5"),
    (".fig .tilt", "fill:%tilt;fill-opacity:.28;stroke:%tilt;stroke-width:1"),
    (".fig .pan", "fill:%pan;fill-opacity:.28;stroke:%pan;stroke-width:1"),
    (".fig .dot", "fill:%track;fill-opacity:.75;stroke:%paper;stroke-width:.8"),
    (".fig .dot.bad", "fill:%paper;fill-opacity:1;stroke:%out;stroke-width:1.6"),
    (".fig .start", "fill:%paper;stroke:%ink;stroke-width:1.4"),
    (".fig .end", "fill:%ink;stroke:%paper;stroke-width:1"),
    (".fig path.view", "fill:%track;fill-opacity:.05;stroke:%muted;stroke-width:1"),
    (".fig .ring", "fill:%out;fill-opacity:.08;stroke:%out;stroke-width:1.2"),
    (".fig .mean", "stroke:%ink;stroke-width:2.4"),
];

/// The style of figures in the light scheme.
fn light() -> String {
    rules_with_colours(|(_, light, _)| light)
}

/// The style of figures in the dark scheme.
fn dark() -> String {
    rules_with_colours(|(_, _, dark)| dark)
}

/// The style of figures: the light scheme, and the dark one where the reader's screen is dark.
pub(super) fn light_and_dark() -> String {
    format!("{}@media screen and (prefers-color-scheme:dark){{{}}}", light(), dark())
}

/// The palette as custom properties of a page: `--ink` and so on.
pub(super) fn properties() -> String {
    let all = |which: fn(Colour) -> &'static str| {
        PALETTE.iter().fold(String::new(), |mut text, colour| {
            let _ = write!(text, "--{}:{};", colour.0, which(*colour));
            text
        })
    };
    format!(
        ":root{{color-scheme:light dark;{}}}@media screen and (prefers-color-scheme:dark){{:root{{{}}}}}",
        all(|(_, light, _)| light),
        all(|(_, _, dark)| dark)
    )
}

fn rules_with_colours(which: fn(Colour) -> &'static str) -> String {
    RULES.iter().fold(String::new(), |mut text, (selector, rule)| {
        let mut rule = (*rule).to_owned();
        for colour in PALETTE {
            rule = rule.replace(&format!("%{}", colour.0), which(colour));
        }
        let _ = writeln!(text, "{selector}{{{rule}}}");
        text
    })
}
