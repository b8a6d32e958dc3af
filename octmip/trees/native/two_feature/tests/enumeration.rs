//! The search for lines against every tree that there is: random problems of a few samples.

use std::sync::atomic::AtomicBool;

use octmip_check::check;
use octmip_frame::control::Limits;
use octmip_oracle::{Case, cost_of, log_of, optimum, random_cases};
use octmip_two_feature::{Options, Switches, solve, write_proof};

#[test]
fn two_feature_trees_cost_what_the_best_of_all_trees_does() {
    for depth in 1..=2 {
        for (seed, Case { problem, question }) in random_cases(depth, 2) {
            let options = Options {
                limits: Limits::default(),
                n_threads: 1,
                known: None,
                seed,
                switches: Switches::default(),
                whole_coefficients: None,
            };
            let found = solve(&problem, &options, (None, None), &mut |_| true).expect("depth 1 or 2");
            let best = optimum(&problem);
            assert_eq!((found.objective, found.bound), (best, best), "depth {depth}, seed {seed}");
            assert_eq!(cost_of(&problem, &found.tree), Some(best), "depth {depth}, seed {seed}");
            let stop = AtomicBool::new(false);
            let body = write_proof(&problem, best, 1, &stop).expect("a proof");
            let report = check(&question, &log_of(&question, best, &body), 1);
            assert_eq!(report.map(|report| report.bound), Ok(best as f64), "depth {depth}, seed {seed}");
            assert!(check(&question, &log_of(&question, best + 1, &body), 1).is_err(), "depth {depth}, seed {seed}");
        }
    }
}
