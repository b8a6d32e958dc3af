//! The costs of a class as every solver counts them: base, cost range and gains.
//!
//! ```text
//! base        the cheapest label of the class: what no tree avoids
//! cost range  the most expensive label less the cheapest: what a prediction can add to the base
//! gain        the most expensive label less the predicted one
//! ```
//!
//! One unit of weight costs `base + cost range - gain`, so the best leaf of some samples is the label of largest gain.

use octmip_check::problem::Problem;

/// Costs of one unit of weight, by class.
#[derive(Debug, Clone)]
pub struct ClassCosts {
    n_classes: usize,
    least: Vec<i64>,
    most: Vec<i64>,
    /// Gain of each label, class after class (`n_classes * n_classes`).
    gains: Vec<i64>,
}

impl ClassCosts {
    /// The costs of a problem.
    pub fn of(problem: &Problem) -> Self {
        let rows = problem.costs.chunks(problem.n_classes);
        let (least, most): (Vec<i64>, Vec<i64>) = rows.clone().map(least_and_most).unzip();
        let gains = rows.zip(&most).flat_map(|(row, most)| row.iter().map(move |cost| most - cost)).collect();
        Self { n_classes: problem.n_classes, least, most, gains }
    }

    /// Cost of the cheapest label of a class.
    pub fn base(&self, class: usize) -> i64 {
        self.least[class]
    }

    /// Cost of the most expensive label of a class.
    pub fn most(&self, class: usize) -> i64 {
        self.most[class]
    }

    /// Most that a prediction can add to the base of a class.
    pub fn range(&self, class: usize) -> i64 {
        self.most[class] - self.least[class]
    }

    /// Gain of predicting a label for a class.
    pub fn gain(&self, class: usize, label: usize) -> i64 {
        self.gains[class * self.n_classes + label]
    }

    /// Gains of all labels for a class (`n_classes`).
    pub fn gains(&self, class: usize) -> &[i64] {
        &self.gains[class * self.n_classes..][..self.n_classes]
    }

    /// The label that gains more for a class than any other, if there is one.
    pub fn sole_best(&self, class: usize) -> Option<usize> {
        let mut best = self.gains(class).iter().enumerate().filter(|(_, gain)| **gain == self.range(class));
        let (label, _) = best.next()?;
        best.next().is_none().then_some(label)
    }

    /// The one label that gains for a class, and its gain: `(0, 0)` where none does, None where several do.
    pub fn only_gain(&self, class: usize) -> Option<(usize, i64)> {
        let mut positive = self.gains(class).iter().enumerate().filter(|(_, gain)| **gain > 0);
        let first = positive.next().map_or((0, 0), |(label, gain)| (label, *gain));
        positive.next().is_none().then_some(first)
    }
}

/// Smallest and largest of a row of costs.
pub fn least_and_most<T: Copy + PartialOrd>(row: &[T]) -> (T, T) {
    let ends = (row[0], row[0]);
    row.iter().fold(ends, |(least, most), &cost| {
        (if cost < least { cost } else { least }, if cost > most { cost } else { most })
    })
}

/// The cost that no tree of a problem avoids.
pub fn base_cost(problem: &Problem) -> i64 {
    let costs = ClassCosts::of(problem);
    (0..problem.n).map(|i| problem.weights[i] * costs.base(problem.labels[i] as usize)).sum()
}

/// Cost and label of the best leaf for all samples, the first label among equals.
pub fn best_leaf(problem: &Problem) -> (i64, usize) {
    let cost = |label: usize| -> i64 {
        (0..problem.n).map(|i| problem.weights[i] * problem.cost(problem.labels[i] as usize, label)).sum()
    };
    (0..problem.n_classes).map(|label| (cost(label), label)).min().unwrap_or((0, 0))
}

/// The cost of a mistake where all cost the same and the true label costs nothing.
pub fn uniform_cost(problem: &Problem) -> Option<i64> {
    let k = problem.n_classes;
    let unit = if k > 1 { problem.cost(0, 1) } else { 1 };
    let is_uniform = (0..k * k).all(|e| problem.cost(e / k, e % k) == if e / k == e % k { 0 } else { unit });
    is_uniform.then_some(unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn problem(costs: Vec<i64>) -> Problem {
        Problem {
            n: 3,
            p: 1,
            n_classes: 3,
            ranks: vec![0, 1, 2].into(),
            n_ranks: vec![3],
            labels: vec![0, 1, 2],
            weights: vec![1, 2, 3],
            costs,
            penalty: 0,
            depth: 1,
            leaf_size: 1,
            sensor_of_feature: vec![0],
            sensor_cost: vec![1.0],
            sensor_limit: 1.0,
            allowed: vec![true],
            planes: None,
        }
    }

    #[test]
    fn a_label_costs_base_and_range_less_its_gain() {
        let problem = problem(vec![1, 4, 2, 7, 0, 5, 3, 3, 3]);
        let costs = ClassCosts::of(&problem);
        for class in 0..3 {
            for label in 0..3 {
                let cost = costs.base(class) + costs.range(class) - costs.gain(class, label);
                assert_eq!(cost, problem.cost(class, label));
            }
        }
        assert_eq!([0, 1, 2].map(|class| costs.only_gain(class)), [None, None, Some((0, 0))]);
        assert_eq!([0, 1, 2].map(|class| costs.sole_best(class)), [Some(0), Some(1), None]);
        assert_eq!(base_cost(&problem), 1 + 3 * 3);
        assert_eq!(best_leaf(&problem), (4 + 3 * 3, 1));
    }

    #[test]
    fn costs_are_uniform_where_every_mistake_costs_the_same() {
        assert_eq!(uniform_cost(&problem(vec![0, 5, 5, 5, 0, 5, 5, 5, 0])), Some(5));
        assert_eq!(uniform_cost(&problem(vec![0, 5, 5, 5, 0, 4, 5, 5, 0])), None);
        assert_eq!(uniform_cost(&problem(vec![1, 5, 5, 5, 1, 5, 5, 5, 1])), None);
    }
}
