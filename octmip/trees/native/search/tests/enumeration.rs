//! Local search against every tree that there is: random problems of a few samples.

use octmip_frame::control::Limits;
use octmip_oracle::{Case, cost_of, optimum, random_cases};
use octmip_search::{Options, search};

#[test]
fn local_search_returns_trees_that_are_allowed_and_mostly_the_best() {
    let (mut n_best, mut n_all) = (0, 0);
    for (depth, split_size) in [(1, 1), (2, 1), (3, 1), (1, 2), (2, 2)] {
        for (seed, Case { problem, .. }) in random_cases(depth, split_size) {
            let options = Options { n_restarts: 4, n_perturbations: 20, seed, n_threads: 1 };
            let found = search(&problem, options, None, Limits::default(), None, &mut |_| true);
            let best = optimum(&problem);
            assert_eq!(cost_of(&problem, &found.tree), Some(found.objective), "depth {depth}, seed {seed}");
            assert!(found.objective >= best && found.bound <= best, "depth {depth}, seed {seed}");
            (n_best, n_all) = (n_best + usize::from(found.objective == best), n_all + 1);
        }
    }
    assert!(10 * n_best >= 9 * n_all, "{n_best} of {n_all}");
}
