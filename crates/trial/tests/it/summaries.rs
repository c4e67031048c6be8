//! Summaries of several trials.

use barrelman_trial::metrics::{Arena, Summary, TrialEntry, TrialMetrics, summarise};

use crate::trial_logs::measured;

fn arena(number: u8) -> Option<Arena> {
    Arena::from_number(number)
}

fn entry(name: &str, number: Option<Arena>, sensitivity: Option<f64>, excursions: usize) -> TrialEntry {
    let metrics = TrialMetrics { sensitivity, excursions, ..measured("..") };
    TrialEntry { name: name.to_owned(), arena: number, metrics }
}

fn pooled(summary: &Summary) -> (Option<f64>, Option<f64>, Option<f64>) {
    let pooled = &summary.pooled;
    (pooled.mean_sensitivity, pooled.normalised_sensitivity, pooled.success_rate)
}

#[test]
fn arenas_are_known_from_file_names() {
    let check = |name: &str, expected: Option<u8>| {
        assert_eq!(Arena::from_name(name).map(Arena::number), expected, "{name}");
    };
    check("arena1_01.csv", Some(1));
    check("arena2_17.csv", Some(2));
    check("arena2", Some(2));
    check("my-arena1.mcap", Some(1));
    check("arena1/7", Some(1));
    check("arena3_01.csv", None);
    check("arena0.csv", None);
    check("arena12.csv", None);
    check("arena.csv", None);
    check("arena", None);
    check("lake_1.csv", None);
    check("", None);
}

#[test]
fn only_the_papers_arenas_have_a_number() {
    assert_eq!([0, 1, 2, 3, 255].map(|number| arena(number).is_some()), [false, true, true, false, false]);
    let [one, two] = [1, 2].map(|number| arena(number).unwrap());
    assert_eq!((one.published_n(), one.published_sensitivity()), (18.0, 0.6045));
    assert_eq!((two.published_n(), two.published_sensitivity()), (13.0, 0.4536));
}

#[test]
fn one_arena_is_pooled_and_normalised_by_the_published_n() {
    let summary = summarise(vec![
        entry("a", arena(2), Some(1.0), 4),
        entry("b", arena(2), Some(1.6), 8),
        entry("c", arena(2), None, 0),
    ]);
    assert_eq!(pooled(&summary), (Some(1.3), Some(1.3 / 13.0), Some(1.0)));
    assert_eq!((summary.arenas.len(), summary.arenas["2"].trials), (1, 3));
    assert_eq!(summary.arenas["2"].pooled, summary.pooled);
}

#[test]
fn several_arenas_have_no_pooled_figures_but_each_its_own() {
    let check = |trials: Vec<TrialEntry>, arenas: &[(&str, f64)]| {
        let summary = summarise(trials);
        assert_eq!(pooled(&summary), (None, None, None));
        let each: Vec<_> = summary
            .arenas
            .iter()
            .map(|(number, figures)| (number.as_str(), figures.pooled.mean_sensitivity.unwrap()))
            .collect();
        assert_eq!(each, arenas);
    };
    let one = || entry("a", arena(1), Some(0.5), 3);
    let two = || entry("b", arena(2), Some(0.25), 3);
    let none = || entry("lake/1", None, Some(2.0), 3);
    check(vec![one(), two()], &[("1", 0.5), ("2", 0.25)]);
    check(vec![none(), two()], &[("2", 0.25)]);
    check(vec![two(), none(), one()], &[("1", 0.5), ("2", 0.25)]);
}

#[test]
fn outside_of_the_papers_arenas_n_is_the_mean_count_of_excursions() {
    let summary = summarise(vec![entry("a", None, Some(1.0), 4), entry("b", None, Some(2.0), 2)]);
    assert_eq!(pooled(&summary), (Some(1.5), Some(0.5), Some(1.0)));
    assert!(summary.arenas.is_empty());
    let still = summarise(vec![entry("a", None, None, 0)]);
    assert_eq!(pooled(&still), (None, None, Some(1.0)));
}

#[test]
fn nothing_comes_to_nothing() {
    assert_eq!(pooled(&summarise(Vec::new())), (None, None, None));
}

#[test]
fn the_success_rate_is_the_share_of_trials_that_were_not_lost() {
    let lost = TrialEntry { metrics: measured(".---"), ..entry("b", None, None, 0) };
    let outside = TrialEntry {
        metrics: TrialMetrics { lost: None, ends_outside: true, ..measured("a") },
        ..entry("c", None, None, 0)
    };
    let kept = || entry("a", None, None, 0);
    assert_eq!(summarise(vec![kept(), lost, kept(), outside]).pooled.success_rate, Some(0.5));
}

#[test]
fn the_document_has_the_promised_fields_and_null_where_undefined() {
    let summary = summarise(vec![entry("arena1_01.csv", arena(1), Some(0.5), 1), entry("x", None, None, 0)]);
    let document = serde_json::to_value(&summary).unwrap();
    let keys =
        |value: &serde_json::Value| -> Vec<String> { value.as_object().unwrap().keys().cloned().collect() };
    let sorted = |text: &str| {
        let mut names: Vec<String> = text.split(',').map(str::to_owned).collect();
        names.sort();
        names
    };
    let mut trial = keys(&document["trials"][0]);
    trial.sort();
    assert_eq!(
        trial,
        sorted(
            "name,arena,samples,duration_s,excursions,complete_excursions,time_outside_s,max_p,mean_h,mean_b_s,\
             duty,travel_rad,effort_rad2_per_s,moves,switches,both_axes,movement_s,variation_rad_per_s,\
             jerk_rad_per_s3,border_s,out_of_picture_s,ends_outside,lost,sensitivity,\
             tracked,blind_s,sure_wrong,first_track_s,reacquire_s,selections"
        )
    );
    let mut top = keys(&document);
    top.sort();
    assert_eq!(top, sorted("trials,arenas,mean_sensitivity,normalised_sensitivity,success_rate"));
    let mut of_arena = keys(&document["arenas"]["1"]);
    of_arena.sort();
    assert_eq!(of_arena, sorted("mean_sensitivity,normalised_sensitivity,success_rate,trials"));
    assert_eq!(document["trials"][0]["arena"], 1);
    assert!(document["trials"][1]["arena"].is_null());
    assert!(document["trials"][1]["sensitivity"].is_null());
    assert!(document["mean_sensitivity"].is_null());
}
