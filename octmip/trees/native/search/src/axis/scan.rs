//! The best axis-aligned rule of one node with the rest of the tree fixed.

use crate::gains::tally::{Tally, Worth};
use crate::prepared::orders::{NodeOrder, Orders};
use crate::tree::rule::Rule;
use crate::tree::view::NodeView;
use octmip_check::problem::Problem;

/// The aim by which a cut is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Aim {
    /// Gain, purity among equals.
    Gain,
    /// Purity alone, as CART does.
    Purity,
}

/// Samples of a node from which on the features are compared by a part of them, about so many, before the leading ones
/// are scanned with all.
const MANY_SAMPLES: usize = 25_000;
const PART: usize = 8_000;
const LEADING: usize = 3;

/// The features that are worth a scan of all samples, ascending: all of them where the samples are few.
///
/// At 10^5 samples of 20 features scans took half of a restart, and most features lose by far on a part already.
pub(crate) fn leading_features(
    problem: &Problem,
    orders: &Orders,
    view: &NodeView,
    features: Vec<u32>,
    (tally, node_order): (&mut Tally, &mut NodeOrder),
    go_on: &dyn Fn() -> bool,
) -> Vec<u32> {
    if view.samples.len() < MANY_SAMPLES || features.len() <= LEADING {
        return features;
    }
    let part = view.every(view.samples.len() / PART);
    let floor = Worth { gain: i64::MIN / 2, purity: 0.0 };
    let mut found = Vec::with_capacity(features.len());
    for &f in &features {
        let scratch = (&mut *tally, &mut *node_order);
        if let Some((_, worth)) = best_cut(problem, orders, &part, &[f], (Aim::Gain, floor), scratch, go_on) {
            found.push((worth, f));
        }
    }
    found.sort_by(|(a, _), (b, _)| b.gain.cmp(&a.gain).then(b.purity.total_cmp(&a.purity)));
    let mut leading: Vec<u32> = found.into_iter().take(LEADING).map(|(_, f)| f).collect();
    leading.sort_unstable();
    if leading.is_empty() { features } else { leading }
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
