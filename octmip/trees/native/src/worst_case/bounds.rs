//! Bounds of pairs of children at an interval of cuts of the root, the labels of both children given.

use crate::worst_case::boxes::{Child, Cuts, Scenario, Trees, scenarios};
use crate::worst_case::instance::{Instance, distinct};
use crate::worst_case::table::{Grid, Table};

/// A child at the cuts of a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Place {
    /// 0 and 1: leaves of the first and the second label; `2 f + 2` and `2 f + 3`: feature f, in both orders of them.
    kind: u32,
    /// Node of the binary tree over the slices of the feature.
    node: u32,
}

impl Place {
    fn feature(self) -> Option<usize> {
        (self.kind as usize / 2).checked_sub(1)
    }

    /// Its labels, left and right.
    fn labels(self, of_side: [usize; 2]) -> [usize; 2] {
        let [first, second] = of_side;
        match (self.kind, self.kind % 2) {
            (0, _) => [first; 2],
            (1, _) => [second; 2],
            (_, 0) => [first, second],
            _ => [second, first],
        }
    }
}

/// Two children.
pub(crate) type Pair = [Place; 2];

/// The children of all roots.
#[derive(Debug)]
pub(crate) struct Children<'a> {
    /// The problem.
    pub(crate) instance: &'a Instance,
    /// Slices of each feature.
    grids: Vec<Grid>,
}

impl<'a> Children<'a> {
    /// Slice the cuts of all features.
    pub(crate) fn new(instance: &'a Instance) -> Self {
        let grids = (0..instance.features.len()).map(|f| Grid::new(instance, f)).collect();
        Self { instance, grids }
    }

    /// All pairs of some labels whose sensors are within the budget.
    pub(crate) fn pairs(&self, root: usize, labels: &[[usize; 2]; 2]) -> Vec<Pair> {
        let n_features = if self.instance.depth > 1 { self.instance.features.len() as u32 } else { 0 };
        let of_side = |[first, second]: [usize; 2]| {
            let n_kinds = if first == second { 1 } else { 2 + 2 * n_features };
            (0..n_kinds).map(|kind| Place { kind, node: 1 })
        };
        let both = of_side(labels[0]).flat_map(|left| of_side(labels[1]).map(move |right| [left, right]));
        let sensor = |feature: usize| self.instance.features[feature].sensor;
        let fits = |pair: &Pair| {
            let read = pair.iter().filter_map(|place| place.feature()).chain([root]).map(sensor);
            self.instance.fits(&distinct(read))
        };
        both.filter(fits).collect()
    }

    /// The number of cuts of a place that can be halved; 0 elsewhere.
    pub(crate) fn width(&self, place: Place) -> u32 {
        let cuts = place.feature().and_then(|f| self.grids[f].cuts(f, place.node as usize));
        cuts.filter(|cuts| self.grids[cuts.feature].has_halves(place.node as usize)).map_or(0, Cuts::width)
    }

    /// Both halves of one child of a pair, those without a cut left out.
    pub(crate) fn halves(&self, pair: Pair, side: usize) -> impl Iterator<Item = Pair> + '_ {
        let half = move |k: u32| {
            let mut half = pair;
            half[side].node = 2 * pair[side].node + k;
            half
        };
        let has_cuts = move |half: &Pair| {
            let place = half[side];
            place.feature().is_none_or(|f| self.grids[f].cuts(f, place.node as usize).is_some())
        };
        [half(0), half(1)].into_iter().filter(has_cuts)
    }

    /// The trees of a pair.
    pub(crate) fn trees(&self, root: Cuts, labels: &[[usize; 2]; 2], pair: Pair) -> Trees {
        let child = |side: usize| {
            let place = pair[side];
            let cuts = place.feature().and_then(|f| self.grids[f].cuts(f, place.node as usize));
            Child { cuts, labels: place.labels(labels[side]) }
        };
        Trees { root, children: [child(0), child(1)] }
    }
}

/// The sums of a child are not found yet.
const NEW: usize = 0;
/// No split of the child has full leaves.
const DEAD: usize = 1;

/// Bounds at one interval of cuts of the root, the sums of each child found once.
#[derive(Debug)]
pub(crate) struct Bounds<'a> {
    instance: &'a Instance,
    table: Table<'a>,
    root_sensor: usize,
    labels: [[usize; 2]; 2],
    n_nodes: usize,
    /// Where the sums of each child begin.
    starts: [Vec<usize>; 2],
    numbers: Vec<i64>,
    scenarios: Vec<Vec<Scenario>>,
    /// What samples without a sure side pay at least: by kind of both children, with the root true and off.
    unsure: [[[i64; 2]; 3]; 3],
}

impl<'a> Bounds<'a> {
    /// Count for a root.
    pub(crate) fn new(children: &'a Children<'a>, root: Cuts, labels: [[usize; 2]; 2]) -> Self {
        let instance = children.instance;
        let table = Table::new(instance, &children.grids, root);
        let n_nodes = children.grids.first().map_or(0, Grid::n_nodes);
        let size = (2 + 2 * instance.features.len()) * n_nodes;
        let least = |row: usize, side: usize, kind: usize| {
            let [first, second] = labels[side].map(|label| instance.cost(row, label));
            [first, second, first.min(second)][kind]
        };
        let paid = |left: usize, right: usize, off: usize| -> i64 {
            let rows = table.unsure[off].iter().enumerate();
            rows.map(|(row, weight)| weight * least(row, 0, left).min(least(row, 1, right))).sum()
        };
        Self {
            unsure: [0, 1, 2].map(|left| [0, 1, 2].map(|right| [0, 1].map(|off| paid(left, right, off)))),
            instance,
            table,
            root_sensor: instance.features[root.feature].sensor,
            labels,
            n_nodes,
            starts: [vec![NEW; size], vec![NEW; size]],
            numbers: vec![0; DEAD + 1],
            scenarios: patterns(instance.n_off),
        }
    }

    fn start(&mut self, side: usize, place: Place) -> usize {
        let at = place.kind as usize * self.n_nodes + place.node as usize;
        if self.starts[side][at] == NEW {
            let split = place.feature().map(|feature| (feature, place.node as usize));
            let has_trees = self.table.has_full_leaves(side, split);
            self.starts[side][at] = if has_trees { self.numbers.len() } else { DEAD };
            if has_trees {
                self.table.push(side, split, place.labels(self.labels[side]), &mut self.numbers);
            }
        }
        self.starts[side][at]
    }

    /// A number that no worst case of the trees of a pair is below; any one of `best` or more where there is such.
    pub(crate) fn of(&mut self, pair: Pair, best: i64) -> i64 {
        let starts = [self.start(0, pair[0]), self.start(1, pair[1])];
        if starts.contains(&DEAD) {
            return best;
        }
        let n_rows = self.instance.n_rows;
        let [left, right] = starts.map(|start| &self.numbers[start..start + 4 + 2 * n_rows]);
        let [ours, theirs] = pair.map(|place| place.kind.min(2) as usize);
        let unsure = self.unsure[ours][theirs];
        let n_splits = 1 + i64::from(ours == 2) + i64::from(theirs == 2);
        let mut worst = 0;
        for off in &self.scenarios[self.pattern(pair)] {
            let [a, b] = [usize::from(off[1]), usize::from(off[2])];
            let cost = if off[0] {
                let (x, y) = (&left[4 + a * n_rows..][..n_rows], &right[4 + b * n_rows..][..n_rows]);
                let band: i64 = x.iter().zip(y).map(|(x, y)| *x.max(y)).sum();
                left[2 + a] + right[2 + b] + band + unsure[1]
            } else {
                left[a] + right[b] + unsure[0]
            };
            worst = worst.max(cost + self.instance.penalty * n_splits);
            if worst >= best {
                break;
            }
        }
        worst
    }

    fn pattern(&self, pair: Pair) -> usize {
        let sensors = pair.map(|place| place.feature().map(|f| self.instance.features[f].sensor));
        let [left, right] = sensors.map(|sensor| match sensor {
            None => 0,
            Some(own) if own == self.root_sensor => 1,
            Some(_) => 2,
        });
        9 * usize::from(left == 2 && sensors[0] == sensors[1]) + 3 * left + right
    }
}

/// Scenarios by 3 times the left child's code plus the right one's: leaf, the root's sensor, another; 9 more: the same.
fn patterns(n_off: usize) -> Vec<Vec<Scenario>> {
    let of = |k: usize| {
        let right = if k < 9 { 2 } else { 1 };
        scenarios([Some(0), [None, Some(0), Some(1)][k % 9 / 3], [None, Some(0), Some(right)][k % 3]], n_off)
    };
    (0..18).map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::worst_case::instance::tests::random_instance;

    #[test]
    fn children_of_one_sensor_are_off_together() {
        assert_eq!(patterns(1)[8], [[true, false, false], [false, true, false], [false, false, true]]);
        assert_eq!(patterns(1)[17], [[true, false, false], [false, true, true]]);
        assert_eq!(patterns(1)[4], [[true, true, true]]);
        assert_eq!(patterns(3)[8], [[true, true, true]]);
    }

    /// The least cost of all trees of a box that have full leaves.
    fn least(trees: Trees, instance: &Instance) -> i64 {
        let worse = |half: Trees| {
            assert!(half.bound(instance) >= trees.bound(instance));
            least(half, instance)
        };
        match trees.halves() {
            Some(halves) => halves.map(worse).into_iter().min().unwrap_or(i64::MAX),
            None => trees.draft(instance).cost(instance).map_or(i64::MAX, |(cost, _)| {
                assert_eq!(cost, trees.bound(instance));
                cost
            }),
        }
    }

    #[test]
    fn no_tree_of_a_box_costs_less_than_its_bounds() {
        for seed in 0..3 {
            let instance = random_instance(seed);
            let children = Children::new(&instance);
            let labels = [[0, 1], [1, 2]];
            let window = |f: usize| instance.features[f].window(1, |_| true);
            for feature in 0..instance.features.len() {
                let (lo, hi) = window(feature).expect("a feature that splits");
                for root in [Cuts { feature, lo, hi }, Cuts { feature, lo, hi: lo }] {
                    let mut bounds = Bounds::new(&children, root, labels);
                    for pair in children.pairs(feature, &labels) {
                        let all = least(children.trees(root, &labels, pair), &instance);
                        assert!(bounds.of(pair, i64::MAX) <= all);
                        for half in children.halves(pair, 1).filter(|_| children.width(pair[1]) > 1) {
                            let part = least(children.trees(root, &labels, half), &instance);
                            assert!(part >= all && bounds.of(half, i64::MAX) <= part);
                        }
                    }
                }
            }
        }
    }
}
