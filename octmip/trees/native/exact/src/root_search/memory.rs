//! Memory of a search, reckoned before it begins; its queues are counted as they grow.
//!
//! Every list is reckoned at the longest that it can become. `n` samples, `p` features, `4 n p` bytes a set of lists.

use crate::node::kept::{MOST_BYTES, MOST_BYTES_OF_CUT};
use crate::samples::label_sets::{WIDTH, most_width};
use crate::samples::unit::unit;
use crate::stumps::aligned::ROOM;
use crate::stumps::width;
use crate::switches::Switches;
use octmip_check::problem::Problem;
use octmip_frame::costs::ClassCosts;

/// A vector of the widest registers, and the most features of a group by width of number [bytes, features]; smaller
/// groups are taken only where they need less room.
const VECTOR: f64 = 64.0;
const SLOTS: [f64; 3] = [16.0, 8.0, 4.0];

/// Bytes of the tables of a search, its queues left out.
pub fn bytes(problem: &Problem, n_threads: usize, switches: &Switches) -> f64 {
    let (n, p) = (problem.n as f64, problem.p as f64);
    let lists = 4.0 * n * p;
    // The samples in the order of each feature; the ranks are the problem's own where every feature is usable.
    let is_whole = (0..problem.p).all(|f| problem.allowed[f] && problem.n_ranks[f] > 1);
    let samples = if is_whole { lists } else { 2.0 * lists } + 28.0 * n;
    // Where splits have a price: the cell of each value, what is lost.
    let cells = if problem.penalty > 0 { lists / 2.0 + 8.0 * n } else { 0.0 };
    // Of leaves of any size beside those of a least one: the same once more, without lists.
    let beside = if problem.leaf_size > 1 { 28.0 * n + cells } else { 0.0 };
    let samples = samples + cells + beside;
    let own = thread(problem, switches);
    if problem.depth < 3 {
        return samples + own;
    }
    let is_tight = problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit;
    let copies = if is_tight { 2.0 * lists + 28.0 * n + cells } else { 0.0 };
    let kept = if has_kept(problem) { MOST_BYTES as f64 } else { 0.0 };
    samples + kept + n_threads as f64 * own + (p * axis(problem, problem.depth)).max(n_threads as f64 * copies)
}

/// Whether results of nodes are kept.
fn has_kept(problem: &Problem) -> bool {
    problem.penalty > 0 && problem.depth > 3
}

/// Workspaces of one thread: the samples on both sides at every level above the last two, cuts, stumps.
fn thread(problem: &Problem, switches: &Switches) -> f64 {
    let (n, p, depth) = (problem.n as f64, problem.p as f64, problem.depth as f64);
    let searches = if problem.leaf_size > 1 { 2.0 } else { 1.0 };
    let sides = searches * (depth - 2.0).max(0.0) * 8.0 * n * p;
    let axes = searches * (depth - 1.0).max(1.0) * axis(problem, 2);
    let kept = if has_kept(problem) { MOST_BYTES_OF_CUT as f64 } else { 0.0 };
    sides + axes + searches * n + stumps(problem, switches) + searches * kept
}

/// The cuts of a feature: position, total range, bounds of both sides; and eight at a time, where there are more labels
/// than a child of this level has leaves, the cost range of each label, or the least that is paid under each set.
fn axis(problem: &Problem, level: usize) -> f64 {
    let (k, n_leaves) = (problem.n_classes, 1 << (level - 1).min(20));
    let labels = if k > n_leaves { k.div_ceil(WIDTH) } else { 0 };
    let sets = if is_plain(problem) { 0 } else { most_width(k, n_leaves) };
    let beside = if problem.leaf_size > 1 { 48.0 } else { 0.0 };
    let prices = if problem.penalty > 0 { 16.0 } else { 0.0 };
    problem.n as f64 * (28.0 + beside + prices + 32.0 * labels.max(sets) as f64)
}

/// Tables of offsets into histograms, histograms, and the change that each sample makes in them.
///
/// Below depth three there is one view and one table; from there on views share a table or have their own, and need
/// numbers of any width up to the widest.
fn stumps(problem: &Problem, switches: &Switches) -> f64 {
    let (n, p) = (problem.n as f64, problem.p as f64);
    if !switches.buckets {
        return 8.0 * p;
    }
    let costs = ClassCosts::of(problem);
    let range = |i: usize| problem.weights[i] * costs.range(problem.labels[i] as usize);
    let total_range = (0..problem.n).map(range).sum::<i64>() / unit(problem, &costs);
    let rows = problem.n_classes as f64;
    // One label a bucket: a third of the samples where the difference of two labels is one row, else a sixth.
    let differences = if problem.n_classes == 2 { n / 3.0 * 5.0 } else { 0.0 };
    let mixed = (n / 6.0).max(512.0f64.min(n)) * (2.0 * rows + 4.0);
    let histogram = VECTOR * mixed.max(differences);
    let widest = width(total_range);
    let (n_tables, widths) = if problem.depth < 3 { (1.0, widest..=widest) } else { (2.0, 0..=widest) };
    let of_width = |slots: &f64| {
        let groups = (p / slots).ceil();
        groups * (4.0 * n_tables * slots * n + histogram + VECTOR / slots * ROOM as f64) + VECTOR / slots * 2.0 * n
    };
    SLOTS[widths].iter().map(of_width).sum()
}

/// Whether each class has one label that costs no more than the others, which cost the same.
fn is_plain(problem: &Problem) -> bool {
    let k = problem.n_classes;
    let wrong = |c: usize| problem.cost(c, (c + 1) % k);
    let same = |c: usize, j: usize| j == c || problem.cost(c, j) == wrong(c);
    (0..k).all(|c| problem.cost(c, c) <= wrong(c) && (0..k).all(|j| same(c, j)))
}
