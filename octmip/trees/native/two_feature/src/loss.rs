//! Costs of samples in leaves, from their weights by class.
//!
//! Samples enter as vectors of `lanes` numbers: total weight by class, then the number of samples (for leaf sizes).

use octmip_check::problem::Problem;
use octmip_frame::costs::{ClassCosts, uniform_cost};

/// The cost of no tree at all.
pub(crate) const INFEASIBLE: i64 = i64::MAX / 4;

/// Costs by class, and the fewest samples of a leaf.
#[derive(Debug, Clone)]
pub struct Loss {
    /// Classes.
    pub(crate) k: usize,
    /// Cost by class of the sample and of the leaf; empty where every mistake costs 1.
    costs: Vec<i64>,
    /// Most that one unit of weight of a class can cost.
    pub(crate) worst: Vec<i64>,
    /// Price of a split over one feature and over two.
    pub(crate) prices: [i64; 2],
    /// Fewest samples in a leaf.
    pub(crate) leaf_size: usize,
}

impl Loss {
    /// The loss of a problem, and the factor by which the weights are to be multiplied.
    ///
    /// Where all mistakes cost the same, that cost goes into the weights and the costs become 0 and 1.
    pub fn of(problem: &Problem) -> (Self, i64) {
        let (k, uniform, class_costs) = (problem.n_classes, uniform_cost(problem), ClassCosts::of(problem));
        let worst = |class: usize| if uniform.is_some() { 1 } else { class_costs.most(class) };
        let loss = Self {
            k,
            costs: if uniform.is_some() { Vec::new() } else { problem.costs.clone() },
            worst: (0..k).map(worst).collect(),
            prices: [problem.penalty, 2 * problem.penalty],
            leaf_size: problem.leaf_size,
        };
        (loss, uniform.unwrap_or(1))
    }

    /// Mistakes between two classes, each at cost 1, and splits free of charge: the loss of moving one split.
    pub fn two_sides() -> Self {
        Self { k: 2, costs: Vec::new(), worst: vec![1; 2], prices: [0, 0], leaf_size: 1 }
    }

    /// Numbers in a vector of samples.
    pub(crate) fn lanes(&self) -> usize {
        self.k + 1
    }

    /// Whether every mistake costs the same.
    pub(crate) fn is_uniform(&self) -> bool {
        self.costs.is_empty()
    }

    /// Cost of one unit of weight of a class under a label.
    pub(crate) fn cost(&self, class: usize, label: usize) -> i64 {
        if self.costs.is_empty() { i64::from(class != label) } else { self.costs[class * self.k + label] }
    }

    /// Cost and label of the best leaf for samples with these class weights.
    pub(crate) fn leaf(&self, weights: &[i64]) -> (i64, usize) {
        let mut best = (INFEASIBLE, 0);
        if self.costs.is_empty() {
            let total: i64 = weights[..self.k].iter().sum();
            for (label, &weight) in weights[..self.k].iter().enumerate() {
                if total - weight < best.0 {
                    best = (total - weight, label);
                }
            }
            return best;
        }
        for label in 0..self.k {
            let cost = (0..self.k).map(|c| weights[c] * self.cost(c, label)).sum();
            if cost < best.0 {
                best = (cost, label);
            }
        }
        best
    }

    /// Cost of the best label for each side, infeasible where a side has fewer than `need` samples.
    pub(crate) fn sides(&self, left: &[i64], right: &[i64], need: i64) -> i64 {
        if left[self.k] < need.max(1) || right[self.k] < need.max(1) {
            return INFEASIBLE;
        }
        self.leaf(left).0 + self.leaf(right).0
    }

    /// Most that samples with these class weights can cost: adding them raises no optimum by more.
    pub(crate) fn most(&self, weights: &[i64]) -> i64 {
        (0..self.k).map(|c| weights[c] * self.worst[c]).sum()
    }

    /// A lower bound of the cost with two labels, where `may_left` and `may_right` hold all samples that may go there.
    ///
    /// A sample that may go to both sides costs at least the cheaper of the two labels; equal labels are one leaf,
    /// which is looked at elsewhere.
    #[inline]
    pub(crate) fn bound(&self, total: &[i64], may_left: &[i64], may_right: &[i64], need: i64) -> i64 {
        if may_left[self.k] < need || may_right[self.k] < need {
            return INFEASIBLE;
        }
        if self.costs.is_empty() {
            let all: i64 = total[..self.k].iter().sum();
            return all - two_labels(&may_left[..self.k], &may_right[..self.k]);
        }
        self.graded_bound(total, may_left, may_right)
    }

    fn graded_bound(&self, total: &[i64], may_left: &[i64], may_right: &[i64]) -> i64 {
        let mut best = INFEASIBLE;
        for a in 0..self.k {
            for b in (0..self.k).filter(|&b| b != a) {
                let cost = (0..self.k)
                    .map(|c| {
                        let (left, right) = (self.cost(c, a), self.cost(c, b));
                        (total[c] - may_right[c]) * left
                            + (total[c] - may_left[c]) * right
                            + (may_left[c] + may_right[c] - total[c]) * left.min(right)
                    })
                    .sum();
                best = best.min(cost);
            }
        }
        best
    }

    /// Cost of samples that may each choose the cheapest of some labels.
    pub(crate) fn choosing(&self, weights: &[i64], labels: &[usize]) -> i64 {
        (0..self.k)
            .map(|c| {
                let cheapest = labels.iter().map(|&label| self.cost(c, label)).min();
                weights[c] * cheapest.unwrap_or(0)
            })
            .sum()
    }
}

/// The largest `left[a] + right[b]` over `a != b`.
#[inline]
fn two_labels(left: &[i64], right: &[i64]) -> i64 {
    let (a1, l1, l2) = two_largest(left);
    let (b1, r1, r2) = two_largest(right);
    if a1 != b1 { l1 + r1 } else { (l1 + r2).max(l2 + r1) }
}

#[inline]
fn two_largest(numbers: &[i64]) -> (usize, i64, i64) {
    let (mut at, mut first, mut second) = (0, -1, -1);
    for (i, &number) in numbers.iter().enumerate() {
        if number > first {
            (at, second, first) = (i, first, number);
        } else if number > second {
            second = number;
        }
    }
    (at, first, second.max(0))
}
