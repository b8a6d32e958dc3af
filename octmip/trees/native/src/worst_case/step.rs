//! The best cut of one node while the others stay: the worst case along every feature, by one walk for each set of
//! sensors that may be off.

use crate::worst_case::draft::{Cost, Draft, Spot};
use crate::worst_case::instance::{HIGH, Instance, LOW, TRUE, subsets};

/// Cuts of a feature that are tried until one has full leaves.
const TRIES: usize = 4;

/// What samples pay at a node, while some sensors elsewhere are off.
struct Payment {
    off: Vec<usize>,
    /// Whether there are fewer sensors off than may be.
    is_short: bool,
    samples: Vec<Paid>,
    /// Cost of the samples that do not reach the node.
    elsewhere: i64,
}

/// A sample that may reach the node pays left, right, and if it may go both ways.
struct Paid {
    sample: u32,
    left: i64,
    right: i64,
}

/// The draft with the best cut that is found for a place, and its cost.
pub(crate) fn best_cut(instance: &Instance, draft: &Draft, place: usize) -> Option<(Cost, Draft)> {
    let others = draft.sensors(instance, Some(place));
    let mut payments: Vec<Payment> = Vec::new();
    for size in [instance.n_off - 1, instance.n_off] {
        for off in subsets(&others, size) {
            if !payments.iter().any(|known| known.off == off) {
                payments.push(payment(instance, draft, place, off));
            }
        }
    }
    let mut best: Option<(i64, usize, u32)> = None;
    let penalty = instance.penalty * draft.splits().count() as i64;
    let mut found: Option<(Cost, Draft)> = None;
    let mut curve = Vec::new();
    for (f, feature) in instance.features.iter().enumerate() {
        let mut sensors = others.clone();
        if !sensors.contains(&feature.sensor) {
            sensors.push(feature.sensor);
        }
        if !instance.fits(&sensors) {
            continue;
        }
        let mut worst = vec![i64::MIN; feature.n_ranks];
        for payment in &payments {
            let is_off = payment.off.contains(&feature.sensor) || payment.is_short;
            along(instance, payment, f, is_off, &mut curve);
            worst.iter_mut().zip(&curve).for_each(|(worst, cost)| *worst = (*worst).max(*cost));
        }
        let mut cuts: Vec<u32> = (0..feature.n_ranks as u32 - 1).collect();
        cuts.retain(|&cut| best.is_none_or(|(cost, _, _)| worst[cut as usize] + penalty <= cost));
        cuts.sort_by_key(|&cut| worst[cut as usize]);
        for cut in cuts.into_iter().take(TRIES) {
            if best.is_some_and(|(cost, _, _)| worst[cut as usize] + penalty > cost) {
                break;
            }
            let mut changed = draft.clone();
            changed.spots[place] = Spot::Split(f, cut);
            let Some(cost) = changed.cost(instance) else { continue };
            if found.as_ref().is_none_or(|(known, _)| cost < *known) {
                best = Some((cost.0, f, cut));
                found = Some((cost, changed));
            }
        }
    }
    found
}

fn payment(instance: &Instance, draft: &Draft, place: usize, off: Vec<usize>) -> Payment {
    let (mut samples, mut elsewhere) = (Vec::new(), 0);
    let nowhere = draft.spots.len();
    for i in 0..instance.n {
        let outside = draft.most(instance, i, 0, &off, place);
        if draft.may_reach(instance, i, place, &off) {
            let [left, right] = [2 * place + 1, 2 * place + 2]
                .map(|side| outside.max(draft.most(instance, i, side, &off, nowhere)).unwrap_or(0));
            samples.push(Paid { sample: i as u32, left, right });
        } else {
            elsewhere += outside.unwrap_or(0);
        }
    }
    Payment { is_short: off.len() < instance.n_off, off, samples, elsewhere }
}

/// The cost at every cut of a feature.
fn along(instance: &Instance, payment: &Payment, feature: usize, is_off: bool, curve: &mut Vec<i64>) {
    let own = &instance.features[feature];
    curve.clear();
    curve.resize(own.n_ranks, 0);
    curve[0] = payment.elsewhere;
    for paid in &payment.samples {
        let rank = |kind: usize| own.ranks[kind][paid.sample as usize] as usize;
        curve[0] += paid.right;
        if is_off {
            let both = paid.left.max(paid.right);
            curve[rank(LOW)] += both - paid.right;
            curve[rank(HIGH)] += paid.left - both;
        } else {
            curve[rank(TRUE)] += paid.left - paid.right;
        }
    }
    for k in 1..curve.len() {
        curve[k] += curve[k - 1];
    }
}
