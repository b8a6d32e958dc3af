//! The exact search against every tree that there is: random problems of a few samples.

use octmip_check::check;
use octmip_check::problem::Problem;
use octmip_check::question::Question;
use octmip_exact::{Helpers, Options, Switches, one_level_deeper, solve, write_proof};
use octmip_frame::control::Limits;
use octmip_frame::effort::Control;
use octmip_oracle::{
    Case, N_CASES, case_of_large_leaves, case_of_many_labels, cost_of, log_of, optimum, problem_of_ranks, random_case,
    random_cases,
};

/// So many of small problems of many kinds; each level more takes several times as long.
fn n_small(depth: usize) -> u64 {
    (4 * N_CASES) >> (depth - 1)
}

/// The solver's log proves the optimum and not one more, on any number of threads.
fn assert_proves(problem: &Problem, question: &Question, best: i64, switches: Switches, seed: u64) {
    let name = format!("depth {}, seed {seed}", problem.depth);
    let [body, by_three] = [1, 3].map(|n_threads| {
        write_proof(problem, best, switches, &Control::new(), Helpers::Threads(n_threads)).expect("a proof")
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
            assert_proves(&problem, &question, best, Switches::default(), seed);
        }
    }
}

#[test]
fn exact_trees_cost_what_the_best_of_all_trees_does() {
    for depth in 1..=3 {
        for (seed, Case { problem, question }) in random_cases(depth, 1) {
            let switches = Switches::default();
            let options = Options { limits: Limits::default(), n_threads: 1, incumbent: None, switches };
            let found = solve(&problem, &options, None, None, None, &mut |_| true).expect("nothing is known before");
            let best = optimum(&problem);
            assert_eq!((found.objective, found.bound), (best, best), "depth {depth}, seed {seed}");
            assert_eq!(cost_of(&problem, &found.tree), Some(best), "depth {depth}, seed {seed}");
            assert_proves(&problem, &question, best, Switches::default(), seed);
        }
    }
}

#[test]
fn trees_of_large_leaves_cost_what_the_best_of_all_such_trees_does() {
    let n_kept = Switches::NAMES.len();
    for (depth, seed) in (1..=4).flat_map(|depth| (0..2 * N_CASES).map(move |seed| (depth, seed))) {
        let rng = &mut fastrand::Rng::with_seed(90_000 * depth as u64 + seed);
        let Case { problem, question } = case_of_large_leaves(rng, depth);
        let off: Vec<&str> =
            Switches::NAMES.iter().copied().filter(|_| seed % 2 == 1 && rng.usize(0..n_kept) < 2).collect();
        let switches = Switches::without(&off).expect("known names");
        let n_threads = 1 + (seed % 3) as usize / 2;
        let options = Options { limits: Limits::default(), n_threads, incumbent: None, switches };
        let found = solve(&problem, &options, None, None, None, &mut |_| true).expect("nothing is known before");
        let best = optimum(&problem);
        let name = format!("depth {depth}, seed {seed}, without {off:?}");
        assert_eq!((found.objective, found.bound), (best, best), "{name}");
        assert_eq!(cost_of(&problem, &found.tree), Some(best), "{name}");
        assert_proves(&problem, &question, best, Switches::default(), seed);
    }
}

#[test]
fn trees_of_large_leaves_of_many_samples_cost_the_same_without_the_bounds_of_smaller_leaves() {
    for seed in 0..24 {
        let rng = &mut fastrand::Rng::with_seed(seed);
        let n = rng.usize(40..80);
        let ranks: Vec<u32> = (0..3 * n).map(|_| rng.u32(0..60)).collect();
        // Runs of few values of one label: leaves of the least size do not fit them.
        let (width, noise) = (rng.u32(5..15), rng.u32(2..12));
        let label = |i: usize| (ranks[i] / width + ranks[n + i] / (2 * width)) % 2;
        let labels: Vec<u32> = (0..n).map(|i| if rng.u32(0..noise) == 0 { rng.u32(0..2) } else { label(i) }).collect();
        let problem = Problem { depth: 3, leaf_size: rng.usize(4..12), ..problem_of_ranks(&ranks, &labels) };
        let [least, without] =
            [Switches::default(), Switches::without(&["free"]).expect("a known name")].map(|switches| {
                let options = Options { limits: Limits::default(), n_threads: 1, incumbent: None, switches };
                let found =
                    solve(&problem, &options, None, None, None, &mut |_| true).expect("nothing is known before");
                assert_eq!(found.objective, found.bound, "seed {seed}");
                found.objective
            });
        assert_eq!(least, without, "seed {seed}");
    }
}

#[test]
fn the_best_trees_of_one_level_fewer_bound_all_trees() {
    // Four samples of four classes: 3 errors of a leaf, 2 of a split, none of two levels.
    assert_eq!([(3, 0), (2, 1)].map(|(errors, level)| one_level_deeper(errors, level, 4, 0)), [2, 0]);
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
        let bound = one_level_deeper(shallower, depth - 1, range, problem.penalty);
        let best = optimum(&problem) - base;
        assert!(bound <= best, "depth {depth}, seed {seed}: {bound} > {best}");
        n_above += usize::from(bound > 0);
    }
    assert!(n_above > 0);
}
