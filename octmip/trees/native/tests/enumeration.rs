//! The solvers, called from Rust, against every tree that there is: random problems of a few samples.

mod oracle;

use _native::control::Limits;
use _native::effort;
use _native::exact;
use _native::problem::Problem;
use _native::search;
use _native::two_feature;
use octmip_check::check;
use octmip_check::question::Question;
use oracle::{Case, case_of_large_leaves, case_of_many_labels, cost_of, optimum, random_case};

/// So many problems of each kind.
const N_CASES: u64 = 45;

/// So many of small problems of many kinds; each level more takes several times as long.
fn n_small(depth: usize) -> u64 {
    (4 * N_CASES) >> (depth - 1)
}

fn cases(depth: usize, split_size: usize) -> impl Iterator<Item = (u64, Case)> {
    let stream = (10 * depth + split_size) as u64 * 1000;
    (stream..stream + N_CASES)
        .map(move |seed| (seed, random_case(&mut fastrand::Rng::with_seed(seed), depth, split_size)))
}

/// A log of what a solver wrote, as Python puts it together.
fn log_of(question: &Question, claim: i64, body: &str) -> String {
    let kind = if question.is_hyperplane { " two-feature" } else { "" };
    let (data, asked) = (question.data_digest(), question.question_digest());
    format!("octmip-proof 3{kind}\ndata {data}\nquestion {asked}\ngrid 0 0\nclaim {claim}\n{body}end\n")
}

/// The solver's log proves the optimum and not one more, on any number of threads.
fn assert_proves(problem: &Problem, question: &Question, best: i64, switches: exact::Switches, seed: u64) {
    let name = format!("depth {}, seed {seed}", problem.depth);
    let [body, by_three] = [1, 3].map(|n_threads| {
        exact::write_proof(problem, best, switches, &effort::Control::new(), n_threads).expect("a proof")
    });
    assert_eq!(body, by_three, "{name}");
    for n_threads in [1, 2] {
        let report = check(question, &log_of(question, best, &body), n_threads);
        assert_eq!(report.map(|report| report.bound), Ok(best as f64), "{name}");
        assert!(check(question, &log_of(question, best + 1, &body), n_threads).is_err(), "{name}");
    }
}

#[test]
fn logs_of_cost_matrices_prove_what_the_best_of_all_trees_costs() {
    for depth in 1..=3 {
        for seed in 0..n_small(depth) {
            let rng = &mut fastrand::Rng::with_seed(9000 * depth as u64 + seed);
            let Case { problem, question } = case_of_many_labels(rng, depth);
            let best = optimum(&problem);
            assert_proves(&problem, &question, best, exact::Switches::default(), seed);
        }
    }
}

#[test]
fn exact_trees_cost_what_the_best_of_all_trees_does() {
    for depth in 1..=3 {
        for (seed, Case { problem, question }) in cases(depth, 1) {
            let switches = exact::Switches::default();
            let options = exact::Options { limits: Limits::default(), n_threads: 1, incumbent: None, switches };
            let found = exact::solve(&problem, &options, &mut |_| true);
            let best = optimum(&problem);
            assert_eq!((found.objective, found.bound), (best, best), "depth {depth}, seed {seed}");
            assert_eq!(cost_of(&problem, &found.tree), Some(best), "depth {depth}, seed {seed}");
            assert_proves(&problem, &question, best, exact::Switches::default(), seed);
        }
    }
}

#[test]
fn trees_of_large_leaves_cost_what_the_best_of_all_such_trees_does() {
    let n_kept = exact::Switches::NAMES.len();
    for (depth, seed) in (1..=4).flat_map(|depth| (0..2 * N_CASES).map(move |seed| (depth, seed))) {
        let rng = &mut fastrand::Rng::with_seed(90_000 * depth as u64 + seed);
        let Case { problem, question } = case_of_large_leaves(rng, depth);
        let off: Vec<&str> =
            exact::Switches::NAMES.iter().copied().filter(|_| seed % 2 == 1 && rng.usize(0..n_kept) < 2).collect();
        let switches = exact::Switches::without(&off).expect("known names");
        let n_threads = 1 + (seed % 3) as usize / 2;
        let options = exact::Options { limits: Limits::default(), n_threads, incumbent: None, switches };
        let found = exact::solve(&problem, &options, &mut |_| true);
        let best = optimum(&problem);
        let name = format!("depth {depth}, seed {seed}, without {off:?}");
        assert_eq!((found.objective, found.bound), (best, best), "{name}");
        assert_eq!(cost_of(&problem, &found.tree), Some(best), "{name}");
        assert_proves(&problem, &question, best, exact::Switches::default(), seed);
    }
}

#[test]
fn the_best_trees_of_one_level_fewer_bound_all_trees() {
    // Four samples of four classes: 3 errors of a leaf, 2 of a split, none of two levels.
    assert_eq!([(3, 0), (2, 1)].map(|(errors, level)| exact::one_level_deeper(errors, level, 4, 0)), [2, 0]);
    let mut n_above = 0;
    for (depth, seed) in (1..=3).flat_map(|depth| (0..n_small(depth)).map(move |seed| (depth, seed))) {
        let drawn = |levels| {
            let rng = &mut fastrand::Rng::with_seed(70_000 + seed);
            let case = if seed % 2 == 0 { random_case(rng, depth, 1) } else { case_of_many_labels(rng, depth) };
            Problem { depth: levels, ..case.problem }
        };
        let problem = drawn(depth);
        let prices = |i: usize| (0..problem.n_classes).map(move |k| (i, k));
        let cost = |(i, k): (usize, usize)| problem.weights[i] * problem.cost(problem.labels[i] as usize, k);
        let least = |i: usize| prices(i).map(cost).min().unwrap_or(0);
        let base: i64 = (0..problem.n).map(least).sum();
        let range: i64 = (0..problem.n).map(|i| prices(i).map(cost).max().unwrap_or(0) - least(i)).sum();
        let shallower = optimum(&drawn(depth - 1)) - base;
        let bound = exact::one_level_deeper(shallower, depth - 1, range, problem.penalty);
        let best = optimum(&problem) - base;
        assert!(bound <= best, "depth {depth}, seed {seed}: {bound} > {best}");
        n_above += usize::from(bound > 0);
    }
    assert!(n_above > 0);
}

#[test]
fn two_feature_trees_cost_what_the_best_of_all_trees_does() {
    for depth in 1..=2 {
        for (seed, Case { problem, question }) in cases(depth, 2) {
            let options = two_feature::options::Options {
                limits: Limits::default(),
                n_threads: 1,
                known: None,
                seed,
                switches: two_feature::switches::Switches::default(),
                whole_coefficients: None,
            };
            let found = two_feature::solve(&problem, &options, &mut |_| true).expect("depth 1 or 2");
            let best = optimum(&problem);
            assert_eq!((found.objective, found.bound), (best, best), "depth {depth}, seed {seed}");
            assert_eq!(cost_of(&problem, &found.tree), Some(best), "depth {depth}, seed {seed}");
            let stop = std::sync::atomic::AtomicBool::new(false);
            let body = two_feature::proof::write(&problem, best, 1, &stop).expect("a proof");
            let report = check(&question, &log_of(&question, best, &body), 1);
            assert_eq!(report.map(|report| report.bound), Ok(best as f64), "depth {depth}, seed {seed}");
            assert!(check(&question, &log_of(&question, best + 1, &body), 1).is_err(), "depth {depth}, seed {seed}");
        }
    }
}

#[test]
fn local_search_returns_trees_that_are_allowed_and_mostly_the_best() {
    let (mut n_best, mut n_all) = (0, 0);
    for (depth, split_size) in [(1, 1), (2, 1), (3, 1), (1, 2), (2, 2)] {
        for (seed, Case { problem, .. }) in cases(depth, split_size) {
            let options = search::Options { n_restarts: 4, n_perturbations: 20, seed, n_threads: 1 };
            let found = search::search(&problem, options, None, Limits::default(), &mut |_| true);
            let best = optimum(&problem);
            assert_eq!(cost_of(&problem, &found.tree), Some(found.objective), "depth {depth}, seed {seed}");
            assert!(found.objective >= best && found.bound <= best, "depth {depth}, seed {seed}");
            (n_best, n_all) = (n_best + usize::from(found.objective == best), n_all + 1);
        }
    }
    assert!(10 * n_best >= 9 * n_all, "{n_best} of {n_all}");
}
