//! What the columns of the report's tables are.

use maud::{Markup, html};

/// The columns, and their definitions.
const COLUMNS: [(&str, &str); 11] = [
    ("Length", "of the trial, s."),
    (
        "Excursions",
        "times that the boat left the ellipse (P > 1); complete ones came back before the trial ended.",
    ),
    ("Outside", "time outside the ellipse, s."),
    ("Largest P", "0 in the middle of the picture, 1 on the ellipse."),
    ("h", "height of an excursion: its largest P less 1. Means are over the complete excursions."),
    ("b", "duration of an excursion, s."),
    (
        "\u{222b}|rate|",
        "integral of the size of the commanded rates over both axes, rad: how far the camera turns.",
    ),
    (
        "\u{222b}rate\u{b2}",
        "integral of the squared rates over both axes, rad\u{b2}/s: the energy of the commands.",
    ),
    ("Moves", "how often the camera starts to move from rest."),
    (
        "Switches",
        "commands followed at once by another one, without rest between them. The paper\u{2019}s law holds one of four \
         commands, which makes a few a trial; the optimal law sets its rates anew with every picture, which makes hundreds, \
         most of them small.",
    ),
    (
        "s",
        "sensitivity of a trial: the mean of h/b over its complete excursions, 1/s; a dash where it has none.",
    ),
];

/// A list of the columns under the table of all trials.
pub(super) fn definitions() -> Markup {
    html! {
        dl class="columns" {
            @for (name, definition) in COLUMNS { dt { (name) } dd { (definition) } }
        }
    }
}
