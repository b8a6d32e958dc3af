//! The unit in which a search counts: the largest number that every cost above the base and the penalty are whole
//! multiples of.
//!
//! Smaller numbers fit narrower lanes of a vector, so the search of costs 0, 20, 40 is that of 0, 1, 2. Multiplying
//! every cost by one number changes no comparison, so both searches are the same to the last cut.

use octmip_check::problem::Problem;
use octmip_frame::costs::ClassCosts;

/// The unit of a problem's costs above the base, 1 or more.
pub(crate) fn unit(problem: &Problem, costs: &ClassCosts) -> i64 {
    let by_class: Vec<i64> =
        (0..problem.n_classes).map(|class| costs.gains(class).iter().fold(0, |a, &b| common_divisor(a, b))).collect();
    let mut unit = problem.penalty;
    for (&weight, &label) in problem.weights.iter().zip(&problem.labels) {
        if unit == 1 {
            break;
        }
        unit = common_divisor(unit, weight * by_class[label as usize]);
    }
    unit.max(1)
}

/// The greatest common divisor; 0 where both are 0.
pub(crate) fn common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { common_divisor(b, a % b) }
}

/// A number in larger units, rounded up.
pub(crate) fn rounded_up(number: i64, unit: i64) -> i64 {
    -(-number).div_euclid(unit)
}
