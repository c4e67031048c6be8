//! Paths, against numbers computed by hand.

use barrelman_sim::path::Path;

fn corner() -> Path {
    Path::from_way_points([(0.0, 0.0), (3.0, 0.0), (3.0, 0.0), (3.0, 4.0)]).expect("three places")
}

#[test]
fn places_lie_along_the_legs() {
    let path = corner();
    assert_eq!(path.length(), 7.0);
    let check = |along: f64, expected: (f64, f64)| {
        let (x, y) = path.point_at(along);
        assert!((x - expected.0).abs() < 1e-12 && (y - expected.1).abs() < 1e-12, "{along}: {x}, {y}");
    };
    check(-1.0, (0.0, 0.0));
    check(1.5, (1.5, 0.0));
    check(3.0, (3.0, 0.0));
    check(5.0, (3.0, 2.0));
    check(9.0, (3.0, 4.0));
}

#[test]
fn the_nearest_place_is_looked_for_ahead_only() {
    let path = corner();
    assert_eq!(path.nearest_arc_length((2.0, 0.5), 0.0, 10.0), 2.0);
    assert_eq!(path.nearest_arc_length((2.0, 0.5), 2.5, 10.0), 2.5, "what lies behind is not looked at");
    assert_eq!(
        path.nearest_arc_length((1.0, 3.0), 0.0, 10.0),
        6.0,
        "the second leg is 2 m away, the first 3 m"
    );
    assert_eq!(path.nearest_arc_length((3.0, 4.0), 0.0, 1.0), 1.0, "no farther than the reach");
}

#[test]
fn fewer_than_two_places_and_no_numbers_are_no_path() {
    assert!(Path::from_way_points([]).is_err());
    assert!(Path::from_way_points([(1.0, 2.0)]).is_err());
    assert!(Path::from_way_points([(1.0, 2.0), (1.0, 2.0)]).is_err());
    assert!(Path::from_way_points([(1.0, 2.0), (f64::NAN, 2.0)]).is_err());
}

#[test]
fn corners_are_where_it_turns_by_more_than_asked() {
    let path = Path::from_way_points([(0.0, 0.0), (2.0, 0.0), (4.0, 0.2), (4.0, 3.0), (4.0, 1.0)])
        .expect("five places");
    let of = |degrees: f64| path.corners(degrees.to_radians()).collect::<Vec<_>>();
    let second = 2.0 + libm::hypot(2.0, 0.2);
    assert_eq!(of(1.0).len(), 3, "its ends are none");
    let found = of(45.0);
    assert!((found[0] - second).abs() < 1e-12 && (found[1] - second - 2.8).abs() < 1e-12, "{found:?}");
    assert_eq!(of(100.0), found[1..], "there and back is the sharpest");
}
