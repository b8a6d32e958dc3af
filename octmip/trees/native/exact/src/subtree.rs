//! Exact subtrees on a subset of the samples, for the local search.

use crate::node::search::Search;
use crate::samples::Samples;
use crate::switches::Switches;
use crate::view::View;
use octmip_frame::effort::Control;
use octmip_frame::tree::Tree;

/// Result of a limited search of a subtree.
#[derive(Debug, Clone)]
pub struct Found {
    /// Objective (of the samples asked for alone) and tree, if one costs less than was asked for.
    pub tree: Option<(i64, Tree)>,
    /// Whether no tree costs less than the one found, or than was asked for.
    pub is_proof: bool,
}

/// The best tree of at most `depth` levels on the samples `ids` that costs less than `upper`, as far as `most`
/// evaluated cuts show it.
///
/// `ids` are indices of the problem's samples, none twice. A search that is stopped from outside finds nothing. The
/// workspaces are made again: what an earlier call has laid out knows nothing of the samples of this one.
pub fn best_subtree(samples: &Samples, control: &Control, ids: &[u32], depth: usize, upper: i64, most: u64) -> Found {
    let limited = control.limited(most);
    if ids.is_empty() {
        return Found { tree: None, is_proof: true };
    }
    let view = View::subset(samples, ids);
    let base: i64 = ids.iter().map(|&i| samples.base[i as usize]).sum();
    let mut search = Search::new(samples, Switches::default(), &limited, depth);
    let result = search.solve(&view, depth, samples.counted(upper.saturating_sub(base)), 0);
    // What was found before the cuts were spent is a tree with its true cost; only the proof is missing.
    let found = result.best.filter(|_| !control.is_stopped());
    Found {
        tree: found.map(|(cost, plan)| (base + samples.cost(cost), plan.tree(samples, &view))),
        is_proof: !limited.is_stopped(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use octmip_check::problem::Problem;
    use octmip_oracle::{cost_of, problem_of_ranks};

    #[test]
    fn fewer_evaluated_cuts_give_true_trees_that_never_beat_the_optimum() {
        let rng = &mut fastrand::Rng::with_seed(1);
        let [ranks, labels]: [Vec<u32>; 2] =
            [(1200, 40), (300, 3)].map(|(n, below)| (0..n).map(|_| rng.u32(0..below)).collect());
        let problem = Problem { depth: 3, ..problem_of_ranks(&ranks, &labels) };
        let (samples, control) = (Samples::new(&problem), Control::new());
        let ids: Vec<u32> = (0..300).collect();
        let search = |most| best_subtree(&samples, &control, &ids, 3, i64::MAX, most);
        let whole = search(u64::MAX);
        assert!(whole.is_proof);
        let optimum = whole.tree.map(|(cost, _)| cost);
        for most in [1, 10, 100, 1000] {
            let (cost, tree) = search(most).tree.expect("a leaf at least");
            assert!(Some(cost) >= optimum);
            assert_eq!(cost_of(&problem, &tree), Some(cost));
        }
    }
}
