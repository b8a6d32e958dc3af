//! Scenarios, mixed to one additive bound.
//!
//! A scenario says which of root, left child and right child are off. The worst case is at least what the tree costs in
//! any scenario that may happen, so also any mean of such costs. A mean separates: what the left child adds depends on
//! the left child alone. Which scenarios may happen depends on the sensors. A scenario that names a node but not
//! another that reads the same sensor costs no more than the one that names both, so it serves as well.

/// Shares of a mixture add up to this.
pub(crate) const WHOLE: i64 = 8;
/// Most mixtures of one type of child.
pub(crate) const MOST: usize = 8;

/// Which nodes are off.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scenario {
    /// The root.
    pub(crate) root: bool,
    /// The left child and the right child.
    pub(crate) children: [bool; 2],
}

const fn off(root: bool, left: bool, right: bool) -> Scenario {
    Scenario { root, children: [left, right] }
}

/// Scenarios with their shares, for trees whose children read the root's sensor or another one.
#[derive(Debug, Clone)]
pub(crate) struct Mixture {
    /// Whether the left and the right child read the sensor of the root; a leaf reads another one.
    pub(crate) same: [bool; 2],
    /// Scenarios and their shares, which add up to `WHOLE`.
    pub(crate) parts: Vec<(Scenario, i64)>,
}

impl Mixture {
    /// Share of the scenarios in which the root is off.
    pub(crate) fn root_share(&self) -> i64 {
        self.parts.iter().filter(|(scenario, _)| scenario.root).map(|(_, share)| share).sum()
    }
}

/// The mixtures that serve while so many sensors may be off.
pub(crate) fn mixtures(n_off: usize) -> Vec<Mixture> {
    let [r, l, m] = [off(true, false, false), off(false, true, false), off(false, false, true)];
    let [rl, rm, lm, rlm] =
        [off(true, true, false), off(true, false, true), off(false, true, true), off(true, true, true)];
    let mut found = vec![mixture([true, true], &[(rlm, 8)])];
    let sides = [([true, false], rl, m), ([false, true], rm, l)];
    for (same, with_root, other) in sides {
        if n_off > 1 {
            found.push(mixture(same, &[(rlm, 8)]));
        } else {
            found.push(mixture(same, &[(with_root, 8)]));
            found.push(mixture(same, &[(with_root, 4), (other, 4)]));
            found.push(mixture(same, &[(other, 8)]));
        }
    }
    let others: Vec<Vec<(Scenario, i64)>> = match n_off {
        1 => vec![vec![(r, 8)], vec![(r, 4), (l, 2), (m, 2)], vec![(l, 4), (m, 4)], vec![(l, 8)], vec![(m, 8)]],
        2 => vec![vec![(rl, 4), (rm, 4)], vec![(rl, 2), (rm, 2), (lm, 4)], vec![(lm, 8)]],
        _ => vec![vec![(rlm, 8)]],
    };
    found.extend(others.iter().map(|parts| mixture([false, false], parts)));
    found
}

fn mixture(same: [bool; 2], parts: &[(Scenario, i64)]) -> Mixture {
    Mixture { same, parts: parts.to_vec() }
}
