//! A regression problem in whole numbers, and what a bound of theirs proves of the true one.
//!
//! Gaps between neighbouring targets that are longer than `2^D` are made as long as that. Targets so moved are no
//! farther apart than they were, any two of them, so that no tree costs more: where a leaf predicts m, let it predict
//! what m is moved to (inside a gap as far up as the moved gap is long), and no sample errs by more.
//!
//! Weights are `floor(w 2^A)` and targets `floor((y - least y) 2^B)`, costs are whole multiples of `2^C` of the unit
//! `2^-(A + qB)`, q = 2 for squared errors (`2^-(A + B) / over` for sloped ones), rounded down wherever they are not.
//! Lower weights and penalties cost every tree less. Targets that are not whole move by less than 1, and that moves a
//! bound G of trees
//!
//! * of sloped error by `W up down / (up + down)` at most, W the total weight: where a leaf predicts m, let it predict
//!   `m - s`, `s = down / (up + down)`. A target y that moved by d, `0 <= d < 1`, is then off by `(y - m) + (s - d)`,
//!   which errs by no more than `y - m` and `s - d` do, and the last by `max(up s, down (1 - s))` at most;
//! * of squared error by less than `2 sqrt(W G)`, where G is above W: errors are squared distances from a linear space,
//!   so the root of each moves by at most `sqrt(W)`, and what penalties add is not moved.

use crate::numbers::exact::Exact;
use crate::regression::bins::Bins;
use crate::regression::question::RegressionQuestion;
use crate::regression::slopes::Slopes;

/// Sums of weights and of weighted targets stay below it: they are numbers of float64.
const MOST_SUM: i128 = 1 << 53;
/// Costs of all trees stay below it.
const MOST_COST: i128 = 1 << 60;

/// Exponents of weights, targets and costs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scale {
    /// Weights are multiplied by this power of two.
    pub weight: i64,
    /// Targets likewise.
    pub target: i64,
    /// Costs are divided by this power of two.
    pub cost: u32,
    /// No gap between two targets counts more than this power of two.
    pub reach: i64,
}

/// Samples and limits in whole numbers.
#[derive(Debug)]
pub struct Samples {
    /// Number of samples.
    pub n: usize,
    /// Number of features.
    pub p: usize,
    /// Dense ranks, feature-major.
    pub ranks: Vec<u32>,
    /// Weights, 0 or more.
    pub weights: Vec<i64>,
    /// Targets, about the middle of their range.
    pub targets: Vec<i64>,
    /// Those of the error; None where it is squared.
    pub slopes: Option<Slopes>,
    /// Price of a split.
    pub penalty: i64,
    /// Levels of splits.
    pub depth: usize,
    /// Fewest samples in a leaf.
    pub leaf_size: usize,
    /// Sensor of each feature, cost of each sensor, the budget with its room for rounding.
    pub sensor_of_feature: Vec<u32>,
    /// Cost of each sensor.
    pub sensor_cost: Vec<f64>,
    /// Most sensor cost in a tree.
    pub sensor_limit: f64,
    /// Samples in the order of their targets.
    pub(crate) by_target: Vec<u32>,
    pub(crate) bins: Bins,
    scale: Scale,
    is_rounded: bool,
}

impl Samples {
    /// A question on a grid; the error says which number is too large for it.
    pub fn on_grid(question: &RegressionQuestion, scale: Scale) -> Result<Self, String> {
        let RegressionQuestion { n, p, .. } = *question;
        let slopes = question.slopes;
        let unit = scale.weight + if slopes.is_some() { 1 } else { 2 } * scale.target - i64::from(scale.cost);
        let steepest = i128::from(slopes.map_or(1, Slopes::steepest));
        let exact = closed_up(&question.targets, scale);
        let weights = floors(question.weights.iter().map(|&w| Exact::of(w).scaled(scale.weight)), "weights")?;
        let places = floors(exact.iter().cloned(), "targets")?;
        let is_rounded = places.iter().zip(&exact).any(|(&place, exact)| Exact::whole(place as u64) < *exact);
        let span = places.iter().copied().max().unwrap_or(0);
        let total: i128 = weights.iter().map(|&w| i128::from(w)).sum();
        if total * i128::from(span.max(1)) * steepest >= MOST_SUM {
            return Err(format!("weights of {total}, targets of {span} and slopes, expected a product below 2^53"));
        }
        let power = if slopes.is_some() { i128::from(span) } else { i128::from(span) * i128::from(span) };
        if (total * power) >> scale.cost >= MOST_COST || (slopes.is_some() && scale.cost != 0) {
            return Err(format!("costs divided by 2^{}, expected them below 2^60, sloped ones whole", scale.cost));
        }
        let targets: Vec<i64> = places.iter().map(|place| place - span / 2).collect();
        let over = Exact::whole(slopes.map_or(1, |slopes| slopes.over) as u64);
        let penalty = Exact::of(question.leaf_penalty).times(&over).scaled(unit).floor().unwrap_or(u64::MAX);
        let mut by_target: Vec<u32> = (0..n as u32).collect();
        by_target.sort_by_key(|&i| targets[i as usize]);
        let column = |f: usize| (0..n).map(|i| question.features[i * p + f]).collect::<Vec<f64>>();
        Ok(Self {
            n,
            p,
            ranks: (0..p).flat_map(|f| crate::ranked::ranks_of(&column(f)).0).collect(),
            slopes,
            penalty: penalty.min(MOST_COST as u64) as i64,
            depth: question.depth,
            leaf_size: question.leaf_size,
            sensor_of_feature: question.sensor_of_feature.clone(),
            sensor_cost: question.sensor_cost.clone(),
            sensor_limit: question.sensor_limit,
            bins: Bins::of(&targets, &by_target),
            weights,
            targets,
            by_target,
            scale,
            is_rounded,
        })
    }

    /// The largest float64 that a bound of whole numbers proves to be one of the problem.
    pub fn value(&self, bound: i64) -> f64 {
        let total: i128 = self.weights.iter().map(|&w| i128::from(w)).sum();
        let on_grid = i128::from(bound) << self.scale.cost;
        let lost = match (self.is_rounded, self.slopes) {
            (false, _) => 0,
            (true, Some(slopes)) => slopes.lost(total),
            (true, None) if on_grid <= total => on_grid,
            // Roots and products are rounded, by far less than the margin.
            (true, None) => {
                (2.0 * (total as f64).sqrt() * (on_grid as f64).sqrt() * (1.0 + 2f64.powi(-48))) as i128 + 1
            }
        };
        let rest = (on_grid - lost).max(0) as u128;
        let (power, over) = self.slopes.map_or((2, 1), |slopes| (1, slopes.over));
        // Sloped costs are below 2^62, and in 2^-64 of their unit each float64 near a quotient is whole: the largest
        // one that is not above the quotient is not above its whole part.
        let (rest, more) = if over == 1 { (rest, 0) } else { ((rest << 64) / over as u128, 64) };
        let exact = Exact::whole((rest >> 64) as u64).scaled(64).plus(&Exact::whole(rest as u64));
        exact.scaled(-self.scale.weight - power * self.scale.target - more).rounded_down()
    }

    /// What a sample costs under a prediction between two numbers on either side of it, rounded up: the most that it
    /// may add to a tree.
    pub(crate) fn range(&self, i: usize, low: i64, high: i64) -> i64 {
        let (above, below) = (i128::from(self.targets[i] - low), i128::from(high - self.targets[i]));
        let power = match self.slopes {
            Some(slopes) => (i128::from(slopes.up) * above).max(i128::from(slopes.down) * below),
            None => above.max(below).pow(2),
        };
        let cost = i128::from(self.weights[i]) * power;
        -((-cost) >> self.scale.cost) as i64
    }

    /// A cost of so many units in whole numbers, rounded down.
    pub(crate) fn floor(&self, cost: i128) -> i64 {
        (cost.max(0) >> self.scale.cost) as i64
    }

    /// Ranks of a feature.
    pub fn ranks_of(&self, f: usize) -> &[u32] {
        &self.ranks[f * self.n..(f + 1) * self.n]
    }

    /// All samples in the order of each feature that may be read (empty for others), and last in that of the targets.
    pub fn orders(&self, may_read: &[bool]) -> Vec<Vec<u32>> {
        let order = |f: usize| {
            let is_in_play = may_read[self.sensor_of_feature[f] as usize];
            let mut order: Vec<u32> = (0..if is_in_play { self.n as u32 } else { 0 }).collect();
            order.sort_by_key(|&i| self.ranks_of(f)[i as usize]);
            order
        };
        let mut orders: Vec<Vec<u32>> = (0..self.p).map(order).collect();
        orders.push(self.by_target.clone());
        orders
    }
}

/// Targets from the least one, long gaps made shorter, in units of the grid and not rounded.
fn closed_up(targets: &[f64], scale: Scale) -> Vec<Exact> {
    let mut order: Vec<usize> = (0..targets.len()).collect();
    order.sort_by(|&i, &j| targets[i].total_cmp(&targets[j]));
    let most = Exact::of(1.0).scaled(scale.reach);
    let (mut moved, mut place) = (vec![Exact::default(); targets.len()], Exact::default());
    for pair in order.windows(2) {
        place = place.plus(&above(targets[pair[1]], targets[pair[0]]).min(most.clone()));
        moved[pair[1]] = place.clone();
    }
    moved.into_iter().map(|place| place.scaled(scale.target)).collect()
}

/// How far a number lies above another that is not larger, exactly.
fn above(number: f64, low: f64) -> Exact {
    match (number >= 0.0, low >= 0.0) {
        (true, true) => Exact::of(number).minus(&Exact::of(low)),
        (true, false) => Exact::of(number).plus(&Exact::of(-low)),
        _ => Exact::of(-low).minus(&Exact::of(-number)),
    }
}

fn floors(numbers: impl Iterator<Item = Exact>, name: &str) -> Result<Vec<i64>, String> {
    let floor = |number: Exact| number.floor().filter(|&floor| i128::from(floor) < MOST_SUM).map(|floor| floor as i64);
    numbers.map(floor).collect::<Option<_>>().ok_or_else(|| format!("{name} on this grid reach 2^53"))
}
