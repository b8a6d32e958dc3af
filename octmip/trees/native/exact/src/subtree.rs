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
    use octmip_frame::tree::Node;

    fn problem(n: usize, p: usize) -> Problem {
        let mut state = 1_u64;
        let mut next = |most: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32 % most
        };
        Problem {
            n,
            p,
            n_classes: 3,
            ranks: (0..n * p).map(|_| next(40)).collect::<Vec<_>>().into(),
            n_ranks: vec![40; p],
            labels: (0..n).map(|_| next(3)).collect(),
            weights: vec![1; n],
            costs: vec![0, 1, 1, 1, 0, 1, 1, 1, 0],
            penalty: 0,
            depth: 3,
            leaf_size: 1,
            sensor_of_feature: (0..p as u32).collect(),
            sensor_cost: vec![1.0; p],
            sensor_limit: f64::INFINITY,
            allowed: vec![true; p],
            planes: None,
        }
    }

    #[test]
    fn fewer_evaluated_cuts_give_true_trees_that_never_beat_the_optimum() {
        let problem = problem(300, 4);
        let (samples, control) = (Samples::new(&problem), Control::new());
        let ids: Vec<u32> = (0..300).collect();
        let search = |most| best_subtree(&samples, &control, &ids, 3, i64::MAX, most);
        let whole = search(u64::MAX);
        assert!(whole.is_proof);
        let optimum = whole.tree.map(|(cost, _)| cost);
        for most in [1, 10, 100, 1000] {
            let cut_short = search(most);
            assert!(cut_short.tree.as_ref().map(|(cost, _)| *cost) >= optimum);
            let (cost, tree) = cut_short.tree.expect("a leaf at least");
            let wrong = ids.iter().filter(|&&i| label(&problem, &tree, i) != problem.labels[i as usize]);
            assert_eq!(wrong.count() as i64, cost);
        }
    }

    fn label(problem: &Problem, tree: &Tree, sample: u32) -> u32 {
        let mut row = 0;
        loop {
            match &tree.nodes[row as usize] {
                Node::Leaf { label } => return *label,
                Node::Split { feature, cut, left, right } => {
                    let goes_left = problem.feature(*feature as usize)[sample as usize] <= *cut;
                    row = if goes_left { *left } else { *right };
                }
                Node::Hyperplane { .. } => unreachable!("the exact core makes no hyperplanes"),
            }
        }
    }
}
