//! The least-energy transfer against an independent conic solver, and its properties.

use barrelman_control::Transfer;
use barrelman_vocab::rng::SplitMix64;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SecondOrderConeT, SolverStatus,
};
use proptest::prelude::*;

/// A random number in [low, high).
fn between(rng: &mut SplitMix64, low: f64, high: f64) -> f64 {
    low + (high - low) * rng.uniform()
}

/// A problem with the ranges of a real camera: P up to 400, gains from nearly zero to those of a long lens,
/// and occasionally an end stop that limits an axis.
fn problem(rng: &mut SplitMix64) -> Transfer {
    let distance =
        libm::sqrt(if rng.uniform() < 0.2 { between(rng, 0.0, 400.0) } else { between(rng, 0.0, 6.0) });
    let bearing = between(rng, -3.2, 3.2);
    let gain = |rng: &mut SplitMix64| {
        let size = libm::pow(10.0, between(rng, -0.5, 1.3));
        match rng.uniform() {
            x if x < 0.05 => 0.0,
            x if x < 0.15 => size * libm::pow(10.0, between(rng, -9.0, -2.0)),
            _ => size,
        }
    };
    let across = |rng: &mut SplitMix64| between(rng, -0.5, 0.5);
    let (pan, tilt) = (gain(rng), gain(rng));
    let limit = |rng: &mut SplitMix64| if rng.uniform() < 0.05 { 0.0 } else { between(rng, 0.05, 2.0) };
    Transfer {
        offset: [distance * libm::cos(bearing), distance * libm::sin(bearing)],
        pan: [-pan, pan * across(rng)],
        tilt: [tilt * across(rng), -tilt],
        aim: between(rng, 0.1, 1.0),
        min_rates: [-limit(rng), -limit(rng)],
        max_rates: [limit(rng), limit(rng)],
    }
}

fn moved(problem: &Transfer, rates: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| problem.offset[i] + problem.pan[i] * rates[0] + problem.tilt[i] * rates[1])
}

fn length(v: [f64; 2]) -> f64 {
    libm::hypot(v[0], v[1])
}

/// The rates of the conic solver: those with the least energy, or, if `nearest`, those with the closest
/// approach. `None` if the solver finds none.
fn conic(problem: &Transfer, nearest: bool) -> Option<[f64; 2]> {
    // Variables: the rates, and for the closest approach its distance.
    let n = if nearest { 3 } else { 2 };
    let mut quadratic = vec![vec![0.0; n]; n];
    let mut linear = vec![0.0; n];
    if nearest {
        linear[2] = 1.0;
    } else {
        (quadratic[0][0], quadratic[1][1]) = (2.0, 2.0);
    }
    let row = |values: [f64; 3]| values[..n].to_vec();
    let a = [
        // Within the limits: b - A u >= 0.
        row([1.0, 0.0, 0.0]),
        row([0.0, 1.0, 0.0]),
        row([-1.0, 0.0, 0.0]),
        row([0.0, -1.0, 0.0]),
        // The cone (radius, c + H u).
        row([0.0, 0.0, -1.0]),
        row([-problem.pan[0], -problem.tilt[0], 0.0]),
        row([-problem.pan[1], -problem.tilt[1], 0.0]),
    ];
    let radius = if nearest { 0.0 } else { problem.aim };
    let b = [
        problem.max_rates[0],
        problem.max_rates[1],
        -problem.min_rates[0],
        -problem.min_rates[1],
        radius,
        problem.offset[0],
        problem.offset[1],
    ];
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .max_iter(200)
        .tol_gap_abs(1e-13)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .build()
        .unwrap();
    let (p, a) = (CscMatrix::from(&quadratic), CscMatrix::from(&a));
    let cones = [NonnegativeConeT(4), SecondOrderConeT(3)];
    let mut solver = DefaultSolver::new(&p, &linear, &a, &b, &cones, settings).unwrap();
    solver.solve();
    match solver.solution.status {
        SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => None,
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {
            Some([solver.solution.x[0], solver.solution.x[1]])
        }
        other => panic!("{other:?} for {problem:?}"),
    }
}

#[test]
fn it_agrees_with_a_conic_solver() {
    let mut rng = SplitMix64::new(1);
    let (mut at_rest, mut feasible, mut infeasible) = (0, 0, 0);
    for case in 0..20_000 {
        let problem = problem(&mut rng);
        let found = problem.solve();
        for axis in 0..2 {
            assert!(
                (problem.min_rates[axis]..=problem.max_rates[axis]).contains(&found.rates[axis]),
                "{case}: {problem:?}"
            );
        }
        let left = length(moved(&problem, found.rates));
        if found.reaches_aim {
            assert!(left <= problem.aim + 1e-9, "{case}: misses by {}: {problem:?}", left - problem.aim);
            let energy = length(found.rates) * length(found.rates);
            if energy == 0.0 {
                at_rest += 1;
                continue;
            }
            feasible += 1;
            if let Some(theirs) = conic(&problem, false) {
                let min_energy = length(theirs) * length(theirs);
                assert!(
                    energy <= min_energy * (1.0 + 1e-6) + 1e-12,
                    "{case}: {energy} against {min_energy}: {found:?} {theirs:?} {problem:?}"
                );
            }
        } else {
            infeasible += 1;
            let theirs = conic(&problem, true).expect("there is always a closest point");
            let nearest = length(moved(&problem, theirs));
            assert!(left <= nearest + 1e-7, "{case}: {left} against {nearest}: {problem:?}");
            assert!(nearest > problem.aim - 1e-7, "{case}: {nearest} is near enough: {problem:?}");
        }
    }
    assert!(at_rest > 500 && feasible > 5_000 && infeasible > 5_000, "{at_rest} {feasible} {infeasible}");
}

fn any_problem() -> impl Strategy<Value = Transfer> {
    any::<u64>().prop_map(|seed| problem(&mut SplitMix64::new(seed)))
}

proptest! {
    #[test]
    fn mirrored_left_to_right_the_answer_is_mirrored(problem in any_problem()) {
        let mirrored = Transfer {
            offset: [-problem.offset[0], problem.offset[1]],
            pan: [problem.pan[0], -problem.pan[1]],
            tilt: [-problem.tilt[0], problem.tilt[1]],
            min_rates: [-problem.max_rates[0], problem.min_rates[1]],
            max_rates: [-problem.min_rates[0], problem.max_rates[1]],
            ..problem
        };
        let (found, other) = (problem.solve(), mirrored.solve());
        prop_assert_eq!(found.reaches_aim, other.reaches_aim);
        for (rate, mirrored) in [(-found.rates[0], other.rates[0]), (found.rates[1], other.rates[1])] {
            prop_assert!((rate - mirrored).abs() <= 1e-9 * (1.0 + rate.abs()), "{:?} {:?}", found, other);
        }
    }

    #[test]
    fn inside_the_aim_nothing_moves(problem in any_problem()) {
        let offset = problem.offset.map(|x| x * 0.99 * problem.aim / length(problem.offset).max(problem.aim));
        prop_assert_eq!(Transfer { offset, ..problem }.solve().rates, [0.0; 2]);
    }

    #[test]
    fn whatever_is_put_in_no_rate_is_beyond_its_limits(numbers in prop::array::uniform11(prop::num::f64::ANY)) {
        let [ox, oy, px, py, tx, ty, aim, min_pan, min_tilt, max_pan, max_tilt] = numbers;
        let problem = Transfer {
            offset: [ox, oy],
            pan: [px, py],
            tilt: [tx, ty],
            aim,
            min_rates: [-min_pan.abs(), -min_tilt.abs()],
            max_rates: [max_pan.abs(), max_tilt.abs()],
        };
        let found = problem.solve();
        for axis in 0..2 {
            let within = problem.min_rates[axis] <= found.rates[axis] && found.rates[axis] <= problem.max_rates[axis];
            prop_assert!(found.rates[axis] == 0.0 || within, "{:?} for {:?}", found, problem);
        }
    }
}

/// The laboratory's camera, and a target that would be seen at (220, -120) px.
#[test]
fn an_example_of_the_laboratory_has_its_numbers() {
    let (focal_px, tilt, a_px, b_px) = (330.0, -24.0_f64.to_radians(), 192.0, 120.0);
    let (x, y) = (220.0, -120.0);
    let (sin, cos) = (libm::sin(tilt), libm::cos(tilt));
    let gain_s = |duration_s: f64, lag_s: f64| duration_s - lag_s * (1.0 - libm::exp(-duration_s / lag_s));
    let (pan_s, tilt_s) = (gain_s(1.22, 0.42), gain_s(1.32, 0.1));
    let pan = [-(focal_px * cos - y * sin + x * x * cos / focal_px), -(x * sin + x * y * cos / focal_px)];
    let tilt = [-x * y / focal_px, -(focal_px + y * y / focal_px)];
    let transfer = Transfer {
        offset: [x / a_px, y / b_px],
        pan: [pan[0] * pan_s / a_px, pan[1] * pan_s / b_px],
        tilt: [tilt[0] * tilt_s / a_px, tilt[1] * tilt_s / b_px],
        aim: 0.704,
        min_rates: [-0.34, -0.3],
        max_rates: [0.34, 0.3],
    };
    let check = |found: f64, documented: f64, digit: f64| {
        assert!((found - documented).abs() <= 0.5 * digit, "{found}, documented {documented}");
    };
    for (found, documented, digit) in [
        (pan_s, 0.823, 1e-3),
        (tilt_s, 1.22, 1e-3),
        (pan[0], -386.6, 0.1),
        (pan[1], 162.6, 0.1),
        (tilt[0], 80.0, 0.1),
        (tilt[1], -373.6, 0.1),
        (transfer.pan[0], -1.657, 1e-3),
        (transfer.pan[1], 1.115, 1e-3),
        (transfer.tilt[0], 0.508, 1e-3),
        (transfer.tilt[1], -3.799, 1e-3),
    ] {
        check(found, documented, digit);
    }
    let found = transfer.solve();
    assert!(found.reaches_aim);
    check(found.rates[0], 0.227, 1e-3);
    check(found.rates[1], -0.158, 1e-3);
    check(1.22 * (found.rates[0] * found.rates[0] + found.rates[1] * found.rates[1]), 0.094, 1e-3);
}
