//! Content of the report's figures and page.

use barrelman_control::Region;
use barrelman_trial::logs::{MarkOnWater, RowTruth, TrialLog, WaterLog, read_text};
use barrelman_trial::metrics::{Arena, TrialEntry, find_excursions, measure};
use barrelman_trial::report::{
    Figure, Report, ReportedTrial, SetKind, TrialSet, TrialTrace, commands, p_over_time, picture_path,
    water_map, world_path,
};
use barrelman_trial::sortie::{Happening, Moment, Sortie};
use barrelman_vocab::{ImagePoint, MarkKind, VehicleProfile, WaterPoint};
use roxmltree::{Document, Node, ParsingOptions};

use crate::laboratory::logs;
use crate::trial_logs::{PICTURE, REGION, command, log_from, log_from_rows};

/// A name that breaks a page unless it is escaped.
const HOSTILE_NAME: &str = "<script>alert('x')</script> & \"quotes\" \u{1}\u{7f}.csv";

fn trace(rows: &str) -> TrialTrace {
    TrialTrace { log: log_from(rows), region: REGION, shadow: None }
}

fn reported(name: &str, log: TrialLog, region: Region, kind: SetKind) -> ReportedTrial {
    let metrics = measure(&log, region, log.picture);
    let entry = TrialEntry { name: name.to_owned(), arena: Arena::from_name(name), metrics };
    let set = TrialSet { kind, name: format!("set of {name}") };
    ReportedTrial { entry, set, sortie: None, trace: Some(TrialTrace { log, region, shadow: None }) }
}

fn report(trials: Vec<ReportedTrial>) -> Report {
    Report::new(trials, "0.1.0".to_owned())
}

/// Parses a figure, which must be XML, and passes it to `inspect`.
fn with_elements<R>(figure: &Figure, inspect: impl Fn(&Document<'_>) -> R) -> R {
    let svg = figure.svg();
    let document = Document::parse(&svg).unwrap_or_else(|error| panic!("{}: {error}\n{svg}", figure.name));
    assert_eq!(document.root_element().tag_name().namespace(), Some("http://www.w3.org/2000/svg"));
    inspect(&document)
}

fn of_class<'a>(document: &'a Document<'_>, element: &str, class: &str) -> Vec<Node<'a, 'a>> {
    let has = |node: &Node<'_, '_>| {
        node.attribute("class").is_some_and(|all| all.split(' ').any(|one| one == class))
    };
    document
        .descendants()
        .filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", element)) && has(node))
        .collect()
}

fn place(node: &Node<'_, '_>, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// Checks the number of excursions in the figures of P and of the picture, and how many of them are open.
#[track_caller]
fn check_excursions(rows: &str, all: usize, open: usize) {
    let trace = trace(rows);
    let p = p_over_time::figure("p", "trial", &trace);
    with_elements(&p, |document| {
        assert_eq!(of_class(document, "line", "b").len(), all, "{rows}: b");
        assert_eq!(of_class(document, "line", "h").len(), all, "{rows}: h");
        assert_eq!(of_class(document, "rect", "wash").len(), all, "{rows}: shaded");
        let is_open =
            of_class(document, "line", "b").iter().filter(|b| b.attribute("class") == Some("b open")).count();
        assert_eq!(is_open, open, "{rows}: open");
    });
    let picture = picture_path::figure("picture", "trial", &trace);
    with_elements(&picture, |document| {
        let paths: usize = of_class(document, "path", "out").len();
        assert_eq!(paths, all, "{rows}: excursions in the picture");
    });
}

#[test]
fn every_excursion_is_drawn_once() {
    check_excursions("", 0, 0);
    check_excursions(".", 0, 0);
    check_excursions("a", 1, 1);
    check_excursions("-", 0, 0);
    check_excursions(".oo.", 0, 0);
    check_excursions(".aab.", 1, 0);
    check_excursions(".a.b.c", 3, 1);
    check_excursions("a--.-b.", 2, 0);
}

#[test]
fn the_boundary_lies_at_1_and_peaks_where_p_is() {
    // P is 0, 4, 0 and 9: h is 3 and 8, the boundary a ninth of the way from 0 to the highest peak.
    let figure = p_over_time::figure("p", "trial", &trace(".b.c."));
    with_elements(&figure, |document| {
        let [boundary] = of_class(document, "line", "bound")[..] else { panic!("one boundary") };
        let level = place(&boundary, "y1");
        assert_eq!(level, place(&boundary, "y2"));
        let heights: Vec<f64> =
            of_class(document, "line", "h").iter().map(|h| place(h, "y1") - place(h, "y2")).collect();
        let per_p = heights[1] / 8.0;
        assert!((heights[0] - 3.0 * per_p).abs() < 0.11, "{heights:?}: coordinates have tenths");
        let [axis] = of_class(document, "line", "axis")[..] else { panic!("one axis") };
        assert!((place(&axis, "y1") - level - per_p).abs() < 0.11, "P = 0 lies one below the boundary");
        for b in of_class(document, "line", "b") {
            assert_eq!((place(&b, "y1"), place(&b, "y2")), (level, level));
        }
    });
}

#[test]
fn the_region_and_the_sectors_are_drawn_to_scale() {
    let figure = picture_path::figure("picture", "trial", &trace(".b."));
    with_elements(&figure, |document| {
        let [frame] = of_class(document, "rect", "frame")[..] else { panic!("one frame") };
        let [region] = of_class(document, "ellipse", "region")[..] else { panic!("one region") };
        let per_px = place(&frame, "width") / f64::from(PICTURE.width);
        assert!((place(&region, "rx") - REGION.a_px * per_px).abs() < 0.1);
        assert!((place(&region, "ry") - REGION.b_px * per_px).abs() < 0.1);
        let sectors = of_class(document, "line", "sector");
        assert_eq!(sectors.len(), 2);
        for sector in sectors {
            let (dx, dy) =
                (place(&sector, "x2") - place(&sector, "x1"), place(&sector, "y2") - place(&sector, "y1"));
            assert!((dx.abs() - dy.abs()).abs() < 0.3, "{dx} {dy}: 45 degrees in pixels");
        }
    });
}

#[test]
fn commands_are_steps_in_two_lanes() {
    let at = Some(ImagePoint { x: 0.0, y: 0.0 });
    let log = log_from_rows(
        [(0.0, 0.0), (0.3, 0.0), (0.3, 0.0), (0.0, -0.3), (0.0, 0.0)]
            .map(|(pan, tilt)| (at, Some(command(pan, tilt)))),
    );
    let figure =
        commands::figure("commands", "trial", &TrialTrace { log, region: REGION, shadow: None }).unwrap();
    with_elements(&figure, |document| {
        for word in ["tilt", "pan"] {
            assert_eq!(of_class(document, "path", word).len(), 1, "{word}");
        }
    });
    assert!(figure.description.contains("1 starts of tilt, 1 of pan"), "{}", figure.description);
    let silent = log_from_rows([(at, None)]);
    assert_eq!(
        commands::figure("commands", "trial", &TrialTrace { log: silent, region: REGION, shadow: None }),
        None
    );
}

#[test]
fn the_path_in_the_world_needs_the_truth() {
    assert_eq!(world_path::figure("world", "trial", &trace(".b.")), None);
    let mut log = log_from(".bb.a");
    let truth = (0..5).map(|row| RowTruth {
        track: None,
        out_of_picture: false,
        achieved_rates: None,
        target_m: (f64::from(row), 2.0),
        camera_m: (0.0, 0.0),
    });
    log.truth = Some(truth.collect());
    let figure =
        world_path::figure("world", "trial", &TrialTrace { log, region: REGION, shadow: None }).unwrap();
    with_elements(&figure, |document| assert_eq!(of_class(document, "path", "out").len(), 2));
}

#[test]
fn names_are_escaped_everywhere() {
    let trial = reported(HOSTILE_NAME, log_from(".a.b."), REGION, SetKind::Recorded);
    let alone =
        ReportedTrial { trace: None, ..reported(HOSTILE_NAME, log_from("a"), REGION, SetKind::Laboratory) };
    let lost = reported(HOSTILE_NAME, log_from(".------"), REGION, SetKind::Simulated);
    let report = report(vec![trial, alone, lost]);
    let page = report.page();
    assert!(!page.contains("<script>alert"), "{page}");
    assert!(page.contains("&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt; &amp; &quot;quotes&quot;"));
    well_formed(&page);
    for figure in report.figures() {
        assert!(
            figure.name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c)),
            "{}",
            figure.name
        );
        with_elements(&figure, |_| ());
    }
}

#[track_caller]
fn well_formed(page: &str) {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    if let Err(error) = Document::parse_with_options(page, options) {
        panic!("{error}");
    }
    // A link that the reader may follow fetches nothing by itself.
    let page = page.replace("<a href=\"https://arxiv.org/", "");
    for outside in ["http-equiv", "src=", "href=\"http", "@import", "url("] {
        assert!(!page.contains(outside), "the page refers to something outside: {outside}");
    }
}

#[test]
fn small_and_empty_reports_are_pages_too() {
    well_formed(&report(Vec::new()).page());
    for rows in ["", ".", "a", "-", "..", "a.", ".------"] {
        let report = report(vec![reported("arena1_01", log_from(rows), REGION, SetKind::Laboratory)]);
        well_formed(&report.page());
        for figure in report.figures() {
            with_elements(&figure, |_| ());
            assert!(
                !figure.svg().contains("NaN") && !figure.svg().contains("inf"),
                "{rows}: {}",
                figure.name
            );
        }
    }
    // A header with no row, and one row, as files.
    let header = "time_s,x,y,pitch_rate,yaw_rate\n";
    assert!(read_text(header).is_err());
    let one = read_text(&format!("{header}0,500,0,0,0\n")).unwrap().log;
    well_formed(&report(vec![reported("one", one, REGION, SetKind::Recorded)]).page());
}

/// Simulated trials of arena 2 in two sets, as two laws make them, from the highest seed down.
fn two_sets() -> Report {
    let trial = |seed: u32, set: &str, rows: &str| {
        let mut trial = reported(&format!("lab2/{seed}"), log_from(rows), REGION, SetKind::Simulated);
        trial.entry.arena = Arena::from_number(2);
        trial.entry.metrics.lost = Some(false);
        trial.set.name = set.to_owned();
        trial
    };
    report(
        (1..=11)
            .rev()
            .flat_map(|seed| [trial(seed, "lab2, schema", ".a.b."), trial(seed, "lab2, optimal", "....")])
            .collect(),
    )
}

#[test]
fn trials_are_ordered_by_their_numbers_and_carry_their_set() {
    let page = two_sets().page();
    let start = page.find("All trials").unwrap();
    let table = &page[start..start + page[start..].find("</table>").unwrap()];
    let names: Vec<&str> =
        table.split("href=\"#t").skip(1).filter_map(|row| row.split(['>', '<']).nth(1)).collect();
    let expected: Vec<String> = (1..=11).map(|seed| format!("lab2/{seed}")).collect();
    assert_eq!(names, [&expected[..], &expected[..]].concat());
    let sets: Vec<&str> =
        table.split("class=\"set\">").skip(1).filter_map(|cell| cell.split('<').next()).collect();
    assert_eq!(sets, [["lab2, optimal"; 11], ["lab2, schema"; 11]].concat());
    for column in ["Switches", "rate\u{b2}, rad\u{b2}/s"] {
        assert!(table.contains(column), "{column}");
    }
    assert!(page.contains("<dt>Switches</dt>"), "the columns are defined");
    assert!(page.contains("of 0 trials that have it"), "a mean says on how many trials it rests");
}

#[test]
fn the_published_sensitivity_is_explained_beside_simulated_ones() {
    let page = two_sets().page();
    assert!(page.contains("leaps of the paper\u{2019}s tracker"), "{page}");
    let laboratory = report(vec![reported("arena2_1", log_from(".a."), REGION, SetKind::Laboratory)]).page();
    assert!(!laboratory.contains("leaps of the paper"), "the logs contain them");
}

#[test]
fn labels_of_the_sensitivities_keep_clear_of_the_published_line() {
    let report = two_sets();
    let figures = report.figures();
    let figure = figures.iter().find(|figure| figure.name == "sensitivity-arena-2").unwrap();
    with_elements(figure, |document| {
        let labels = of_class(document, "text", "name");
        assert!(labels.len() >= 2);
        for label in &labels {
            let baseline = place(label, "y");
            for line in of_class(document, "line", "bound") {
                let (top, bottom) = (place(&line, "y1"), place(&line, "y2"));
                assert!(bottom <= baseline - 9.0 || top >= baseline, "{top} to {bottom} crosses {baseline}");
            }
        }
    });
}

#[test]
fn the_map_of_the_water_shows_boat_marks_and_view() {
    let at = |x: f64, y: f64| WaterPoint { x, y };
    let mark = |id: u32, path: Vec<WaterPoint>, radius_m: f64, was_destination: bool| MarkOnWater {
        id,
        kind: if radius_m > 0.0 { MarkKind::Person } else { MarkKind::Place },
        path,
        radius_m,
        std_dev_m: 0.8,
        was_destination,
    };
    let water = WaterLog {
        boat: vec![Some(at(0.0, 8.0)), Some(at(4.0, 12.0)), None, Some(at(9.0, 18.0))],
        marks: vec![
            mark(1, vec![at(10.0, 20.0)], 2.0, true),
            mark(2, vec![at(3.0, 15.0), at(5.0, 15.0)], 3.0, false),
            mark(3, vec![at(-4.0, 9.0)], 0.0, false),
        ],
        views: Some([[at(-5.0, 6.0), at(-300.0, 400.0), at(300.0, 400.0), at(5.0, 6.0)]; 2]),
    };
    let trace =
        TrialTrace { log: TrialLog { water: Some(water), ..log_from("...") }, region: REGION, shadow: None };
    let figure = water_map::figure("water", "trial", &trace).unwrap();
    with_elements(&figure, |document| {
        let rings = of_class(document, "circle", "ring");
        // The stand-off of 2 m and the keep-out of 3 m on one scale; a place has no circle.
        let radii: Vec<f64> = rings.iter().map(|ring| place(ring, "r")).collect();
        assert!(radii.len() == 2 && (radii[1] / radii[0] - 1.5).abs() < 0.01, "{radii:?}");
        assert_eq!(of_class(document, "path", "view").len(), 2);
        let way = of_class(document, "path", "track");
        // The way is interrupted where the boat was not known.
        assert_eq!(way[0].attribute("d").unwrap().matches('M').count(), 2);
        let words = |text: &str| document.descendants().any(|node| node.text() == Some(text));
        assert!(words("person 1: destination") && words("person 2") && words("place 3"));
    });
    assert_eq!(water_map::figure("water", "trial", &self::trace("...")), None, "no boat was commanded");
}

#[test]
fn the_claim_and_the_count_stand_beside_each_other() {
    let trials = ["....", ".aa.", "..aa"].into_iter().enumerate().map(|(index, rows)| {
        let log = TrialLog { records_track_loss: false, ..log_from(rows) };
        let mut trial = reported(&format!("arena2_{index}"), log, REGION, SetKind::Laboratory);
        trial.set.name = "laboratory logs".to_owned();
        trial
    });
    let page = report(trials.collect()).page();
    assert!(
        page.contains(
            "claims 100\u{a0}% success; of 3 laboratory logs 1 ends outside the ellipse: arena2_2."
        ),
        "{page}"
    );
    assert!(page.contains("0.4536") && page.contains("2 of 3"), "{page}");
}

#[test]
fn the_laboratorys_logs_are_reported_as_they_are() {
    let Some(logs) = logs() else { return };
    let shares = VehicleProfile::fotokite_pro().region;
    let trials: Vec<ReportedTrial> = logs
        .iter()
        .map(|(name, text)| {
            let log = read_text(text).unwrap().log;
            let region = log.region(shares);
            let mut trial = reported(name, log, region, SetKind::Laboratory);
            trial.set.name = "laboratory logs".to_owned();
            trial
        })
        .collect();
    let counts: Vec<usize> = trials
        .iter()
        .map(|trial| trial.trace.as_ref().map_or(0, |trace| find_excursions(&trace.log, trace.region).len()))
        .collect();
    let report = report(trials);
    let page = report.page();
    well_formed(&page);
    for words in [
        "of 30 laboratory logs 4 end outside",
        "arena2_03, arena2_04, arena2_05 and arena2_07",
        "0.6055",
        "0.4535",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let figures = report.figures();
    let of_p: Vec<&Figure> = figures.iter().filter(|figure| figure.name.ends_with("-p")).collect();
    for (figure, count) in of_p.iter().zip(&counts) {
        let lines = with_elements(figure, |document| of_class(document, "line", "b").len());
        assert_eq!(lines, *count, "{}", figure.name);
    }
    for (figure, dots) in figures.iter().filter(|figure| figure.name.starts_with("sensitivity")).zip([13, 17])
    {
        assert_eq!(
            with_elements(figure, |document| of_class(document, "circle", "dot").len()),
            dots,
            "{}",
            figure.name
        );
    }
}

#[test]
fn the_report_of_a_sortie_speaks_of_a_sortie() {
    let noted = Happening::Noted { text: "smoke".to_owned().try_into().unwrap() };
    let sortie = Sortie {
        length_s: 12.0,
        engaged_s: 10.0,
        followed_s: 9.0,
        moments: vec![Moment { at_s: 4.0, what: noted }],
        ..Sortie::default()
    };
    let lines = sortie.lines();
    let trial = ReportedTrial {
        sortie: Some(sortie),
        ..reported("run-1", log_from(".a.b."), REGION, SetKind::Sortie)
    };
    let report = report(vec![trial]);
    assert_eq!(report.contents(), "1 sortie");
    let page = report.page();
    well_formed(&page);
    for words in [&lines[1], "The sortie", "Sortie by sortie", "<td>4.0</td><td>moment marked: smoke</td>"] {
        assert!(page.contains(words), "{words}");
    }
    for words in ["Trial by trial", "All trials", "Claimed and counted", "simulated trial "] {
        assert!(!page.contains(words), "{words}");
    }
}
