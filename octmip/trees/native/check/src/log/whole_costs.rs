//! Weights, costs and penalty as whole numbers that the true ones are not below, so that a bound of theirs is one of
//! the problem.

use std::collections::HashSet;

use crate::input::question::Question;
use crate::numbers::exact::Exact;
use crate::refusal::{Checked, ensure};

/// Sums of costs stay below it, so that they fit into 64 bits with room for every sum of three.
pub(crate) const CAPACITY: i64 = 1 << 61;
/// Rows of costs that a log may have beyond those of the classes: a table of them squared is held in memory.
const MOST_OWN_ROWS: usize = 1024;

/// Whole numbers: a sample `i` with label `k` costs `weights[i] * costs[rows[i] * n_rows + k]`.
pub(crate) struct WholeCosts {
    pub(crate) n_rows: usize,
    pub(crate) rows: Vec<u32>,
    pub(crate) weights: Vec<i64>,
    pub(crate) costs: Vec<i64>,
    /// Of one feature in one split.
    pub(crate) penalty: i64,
    /// Of the unit: a cost of 1 is one of 2^-exponent.
    exponent: i64,
    /// Cost of the cheapest labels, which is paid besides.
    unavoidable: Exact,
}

impl WholeCosts {
    /// A bound in whole numbers as one in the problem's units, rounded down.
    pub(crate) fn value(&self, bound: i64) -> f64 {
        self.unavoidable.plus(&Exact::whole(bound as u64).scaled(-self.exponent)).rounded_down()
    }
}

/// Weights times 2^`weight_exponent`, costs times 2^`cost_exponent` and the penalty times both, rounded down.
pub(crate) fn rounded(
    question: &Question,
    weight_exponent: i64,
    cost_exponent: i64,
    line: usize,
) -> Checked<WholeCosts> {
    let weights = floors(&question.weights, weight_exponent);
    let costs = floors(&question.costs, cost_exponent);
    let most = most_cost(weights.as_deref(), costs.as_deref()).unwrap_or(CAPACITY);
    ensure!(most < CAPACITY, line, "on this grid a tree may cost 2^61 or more, which is beyond the checker's numbers");
    let exponent = weight_exponent + cost_exponent;
    // A penalty above every other cost forbids splits; so does a smaller one that is above them.
    let penalty = floors(&[question.leaf_penalty], exponent).map_or(most + 1, |floors| floors[0].min(most + 1));
    Ok(WholeCosts {
        n_rows: question.n_classes,
        rows: question.labels.clone(),
        weights: weights.unwrap_or_default(),
        costs: costs.unwrap_or_default(),
        penalty,
        exponent,
        unavoidable: Exact::default(),
    })
}

/// Numbers times a power of two, rounded down; None if one reaches the capacity.
fn floors(numbers: &[f64], exponent: i64) -> Option<Vec<i64>> {
    let floor = |&number: &f64| Exact::of(number).scaled(exponent).floor().filter(|&floor| floor < CAPACITY as u64);
    numbers.iter().map(|number| floor(number).map(|floor| floor as i64)).collect()
}

/// All weights together times the largest cost, of 1 at least; None if that does not fit, or numbers are missing.
fn most_cost(weights: Option<&[i64]>, costs: Option<&[i64]>) -> Option<i64> {
    let total = weights?.iter().try_fold(0i64, |total, &weight| total.checked_add(weight))?;
    total.checked_mul(costs?.iter().copied().max().unwrap_or(0).max(1))
}

/// Costs, row by row, a row and a weight for each sample, and the penalty, as a log writes them out: all compared with
/// the true ones. `line` is that of the penalty.
pub(crate) fn written_out(
    question: &Question,
    exponent: i64,
    [table, rows, weights]: [Vec<i64>; 3],
    penalty: i64,
    line: usize,
) -> Checked<WholeCosts> {
    let (n, k, n_rows) = (question.n, question.n_classes, table.len() / question.n_classes);
    let (costs_line, rows_line, weights_line) = (line - 3, line - 2, line - 1);
    let is_table = table.len() == n_rows * k && (k..=k + MOST_OWN_ROWS).contains(&n_rows);
    let got = table.len();
    ensure!(is_table, costs_line, "got {got} costs, expected rows of {k}: from {k} rows to {}", k + MOST_OWN_ROWS);
    let are_rows = rows.len() == n && rows.iter().all(|&row| (row as usize) < n_rows);
    let got = rows.len();
    ensure!(are_rows, rows_line, "got {got} rows of samples, expected {n} below {n_rows}");
    let got = weights.len();
    ensure!(got == n, weights_line, "got {got} weights, expected {n}");
    check_below(question, exponent, [&table, &rows, &weights], weights_line)?;
    let is_below = Exact::whole(penalty as u64).scaled(-exponent) <= Exact::of(question.leaf_penalty);
    ensure!(is_below, line, "the penalty {penalty} is above the problem's, {}", question.leaf_penalty);
    Ok(WholeCosts {
        n_rows,
        rows: rows.iter().map(|&row| row as u32).collect(),
        weights,
        costs: squared(&table, k),
        penalty,
        exponent,
        unavoidable: unavoidable(question),
    })
}

/// Refuse a weight times a cost that is above what the label costs more than the cheapest one does.
fn check_below(question: &Question, exponent: i64, [table, rows, weights]: [&[i64]; 3], line: usize) -> Checked<()> {
    let k = question.n_classes;
    let beyond_cheapest = excess_costs(question);
    let (mut total, mut seen) = (0u128, HashSet::new());
    for (i, (&row, &weight)) in rows.iter().zip(weights).enumerate() {
        let (c, own) = (question.labels[i] as usize, &table[row as usize * k..][..k]);
        total += weight as u128 * own.iter().copied().max().unwrap_or(0) as u128;
        if !seen.insert((row, weight, c, question.weights[i].to_bits())) {
            continue;
        }
        let (whole, true_weight) = (Exact::whole(weight as u64).scaled(-exponent), Exact::of(question.weights[i]));
        for (label, &cost) in own.iter().enumerate() {
            let is_below =
                whole.times(&Exact::whole(cost as u64)) <= true_weight.times(&beyond_cheapest[c * k + label]);
            ensure!(is_below, line, "sample {i}, class {label}: {weight} x {cost} is above the true cost");
        }
    }
    ensure!(total < CAPACITY as u128, line, "with these weights a tree may cost {total}, expected less than 2^61");
    Ok(())
}

/// Cost of each label above that of the cheapest one, row by row.
fn excess_costs(question: &Question) -> Vec<Exact> {
    let rows = question.costs.chunks(question.n_classes);
    let row = |row: &[f64]| {
        let cheapest = Exact::of(row.iter().copied().fold(f64::INFINITY, f64::min));
        row.iter().map(|&cost| Exact::of(cost).minus(&cheapest)).collect::<Vec<_>>()
    };
    rows.flat_map(row).collect()
}

/// Cost of the cheapest labels of all samples.
fn unavoidable(question: &Question) -> Exact {
    let cheapest = |row: &[f64]| row.iter().copied().fold(f64::INFINITY, f64::min);
    let costs: Vec<f64> = question.costs.chunks(question.n_classes).map(cheapest).collect();
    let mut totals = vec![Exact::default(); costs.len()];
    for (&label, &weight) in
        question.labels.iter().zip(&question.weights).filter(|(label, _)| costs[**label as usize] > 0.0)
    {
        totals[label as usize] = totals[label as usize].plus(&Exact::of(weight));
    }
    let paid = totals.iter().zip(&costs).map(|(total, &cost)| total.times(&Exact::of(cost)));
    paid.fold(Exact::default(), |sum, paid| sum.plus(&paid))
}

/// A table of `k` columns with as many columns as rows. Those beyond are no labels, and cost as much as the worst one.
fn squared(table: &[i64], k: usize) -> Vec<i64> {
    let n_rows = table.len() / k;
    let row = |row: &[i64]| {
        let mut row = row.to_vec();
        row.resize(n_rows, row.iter().copied().max().unwrap_or(0));
        row
    };
    table.chunks(k).flat_map(row).collect()
}
