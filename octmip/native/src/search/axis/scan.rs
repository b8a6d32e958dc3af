//! The best axis-aligned rule of one node with the rest of the tree fixed.

use crate::problem::Problem;
use crate::search::gains::tally::{Tally, Worth};
use crate::search::prepared::orders::{NodeOrder, Orders};
use crate::search::tree::rule::Rule;
use crate::search::tree::view::NodeView;

/// The aim by which a cut is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aim {
    /// Gain, purity among equals.
    Gain,
    /// Purity alone, as CART does.
    Purity,
}

/// Scan every cut of the features given, as far as the caller lets it go on; return the best rule that beats `floor`.
///
/// One pass per feature: all samples start on the right and cross to the left in the feature's order; a cut is judged
/// wherever the value changes, the last value left out (it would leave the right side empty).
pub(crate) fn best_cut(
    problem: &Problem,
    orders: &Orders,
    view: &NodeView,
    features: &[u32],
    (aim, floor): (Aim, Worth),
    scratch: (&mut Tally, &mut NodeOrder),
    go_on: &dyn Fn() -> bool,
) -> Option<(Rule, Worth)> {
    let (tally, node_order) = scratch;
    let penalty = problem.penalty;
    node_order.enter(problem.n, &view.samples);
    view.fill(tally, |_| false);
    let all_right = tally.clone();
    let crossings = tally.crossings(&view.members);
    let (mut best, mut found) = (floor, None);
    for &f in features {
        if !go_on() {
            break;
        }
        node_order.sort(problem, orders, &view.samples, f);
        tally.copy_from(&all_right);
        let ranks = problem.feature(f as usize);
        for (k, &j) in node_order.order.iter().enumerate() {
            let (j, i) = (j as usize, view.samples[j as usize]);
            match &crossings {
                Some(crossings) => tally.cross(&crossings[j]),
                None => view.members[j].cross(tally, false),
            }
            let gain = if aim == Aim::Gain { tally.total - penalty } else { floor.gain };
            if gain < best.gain {
                continue;
            }
            let Some(&next) = node_order.order.get(k + 1) else {
                break;
            };
            let rank = ranks[i as usize];
            if rank != ranks[view.samples[next as usize] as usize] && tally.is_large_enough() {
                let worth = Worth { gain, purity: tally.purity() };
                if worth.beats(&best) {
                    best = worth;
                    found = Some(Rule::Axis { feature: f, cut: rank });
                }
            }
        }
    }
    found.map(|rule| (rule, best))
}
