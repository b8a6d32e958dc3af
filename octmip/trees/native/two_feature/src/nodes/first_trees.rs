//! First trees: root and children improved in turn, each exactly with the others fixed, from many random roots.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use crate::geometry::line::Line;
use crate::line_tree::LineTree;
use crate::loss::{INFEASIBLE, Loss};
use crate::nodes::node::SearchContext;
use crate::regions::dual_plane::REGIONS;
use crate::regions::slope_interval::SlopeInterval;
use crate::stumps::search::StumpTask;
use crate::stumps::solver::best_split;
use crate::weighted_samples::WeightedSamples;

/// Slope intervals that are scanned in one move, and regions of them that are split.
const INTERVALS: usize = 64;
const TRIED: usize = 8;
const MOST_ROUNDS: usize = 8;

/// A random number generator (an LCG's upper bits: plenty for choosing intervals).
struct Draws(u64);

impl Draws {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }
}

/// The best tree of depth 2 found from random roots within the dual planes of `intervals`, until `patience` in a row
/// fail.
pub(crate) fn first_tree(
    context: &SearchContext<'_>,
    intervals: &Arc<Vec<SlopeInterval>>,
    patience: usize,
    seed: u64,
    floor: i64,
) -> Option<(i64, LineTree)> {
    let mut draws = Draws(seed ^ 0x9e37_79b9_7f4a_7c15);
    let mut best: Option<(i64, LineTree)> = None;
    let mut n_vain = 0;
    while n_vain < patience {
        n_vain += 1;
        let is_done = best.as_ref().is_some_and(|(cost, _)| *cost <= floor);
        if is_done || context.stop.load(Ordering::Relaxed) || intervals.is_empty() {
            break;
        }
        let mut line = random_root(context, intervals, &mut draws);
        let mut last = INFEASIBLE;
        for _ in 0..MOST_ROUNDS {
            let children = context.best_children(line, intervals, &mut draws);
            let cost = children[0].0 + children[1].0 + context.instance.samples().price(line.features);
            if cost >= last {
                break;
            }
            last = cost;
            let stumps = children.map(|(_, line)| line);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                let line_trees = stumps.map(LineTree::stump);
                best = Some((cost, LineTree::Split(line, Box::new(line_trees))));
                n_vain = 0;
            }
            match context.move_root(line, stumps, intervals, &mut draws) {
                Some(moved) => line = moved,
                None => break,
            }
        }
    }
    best
}

/// The middle line of a random region, neither among the lowest nor among the highest of its slope interval.
fn random_root(context: &SearchContext<'_>, intervals: &[SlopeInterval], draws: &mut Draws) -> Line {
    let interval = one_of(intervals[draws.below(intervals.len())], draws);
    let dual_plane = &context.dual_planes[interval.dual_plane as usize];
    let (k, bin) = (interval.first as usize, 4 + draws.below(REGIONS - 8));
    let (t, r) = dual_plane.region((k, k + 1), (bin, bin + 1)).center();
    Line { features: dual_plane.features, t, r }
}

impl SearchContext<'_> {
    fn sides(&self, line: Line) -> [Vec<u32>; 2] {
        let plane = &self.instance.plane;
        let (left, right) = self.all.iter().partition(|&&i| line.sends_left(plane, i));
        [left, right]
    }

    fn best_children(&self, root: Line, intervals: &[SlopeInterval], draws: &mut Draws) -> [(i64, Option<Line>); 2] {
        self.sides(root).map(|ids| {
            let task = StumpTask::tried(&ids, self.instance.loss.leaf_size as i64, TRIED);
            let mut chosen = some_intervals(intervals, draws);
            let samples = self.instance.samples();
            let result = best_split(samples, &self.dual_planes, task, [], &mut chosen, self.stop);
            (result.incumbent, result.line)
        })
    }

    /// The root that sends most weight to the child that does better by it.
    fn move_root(
        &self,
        root: Line,
        children: [Option<Line>; 2],
        intervals: &[SlopeInterval],
        draws: &mut Draws,
    ) -> Option<Line> {
        let sides = self.sides(root);
        let costs = [0, 1].map(|s| self.costs_under(children[s], &sides[s]));
        let labels: Vec<u32> = (0..self.all.len()).map(|i| u32::from(costs[1][i] < costs[0][i])).collect();
        let weights: Vec<i64> = (0..self.all.len()).map(|i| (costs[1][i] - costs[0][i]).abs()).collect();
        let loss = Loss::two_sides();
        let matter: Vec<u32> = self.all.iter().copied().filter(|&i| weights[i as usize] > 0).collect();
        let samples = WeightedSamples {
            plane: &self.instance.plane,
            labels: &labels,
            weights: &weights,
            loss: &loss,
            switches: self.instance.switches,
        };
        let task = StumpTask::tried(&matter, 1, TRIED);
        let mut chosen = some_intervals(intervals, draws);
        best_split(samples, &self.dual_planes, task, [root], &mut chosen, self.stop).line
    }

    /// Cost of every sample under a child whose labels are the best for its own samples.
    fn costs_under(&self, child: Option<Line>, own: &[u32]) -> Vec<i64> {
        let (samples, plane) = (self.instance.samples(), &self.instance.plane);
        let goes_left = |i: u32| child.is_none_or(|line| line.sends_left(plane, i));
        let (left, right): (Vec<u32>, Vec<u32>) = own.iter().partition(|&&i| goes_left(i));
        let labels = [left, right].map(|ids| samples.loss.leaf(&samples.tally(&ids)).1);
        self.all
            .iter()
            .map(|&i| {
                let label = labels[usize::from(!goes_left(i))];
                let class = samples.labels[i as usize] as usize;
                samples.weights[i as usize] * samples.loss.cost(class, label)
            })
            .collect()
    }
}

fn some_intervals(intervals: &[SlopeInterval], draws: &mut Draws) -> Vec<SlopeInterval> {
    let n_intervals: usize = intervals.iter().map(|interval| interval.n_intervals as usize).sum();
    if n_intervals <= INTERVALS {
        return intervals.to_vec();
    }
    (0..INTERVALS).map(|_| one_of(intervals[draws.below(intervals.len())], draws)).collect()
}

fn one_of(interval: SlopeInterval, draws: &mut Draws) -> SlopeInterval {
    let first = interval.first + draws.below(interval.n_intervals as usize) as u16;
    SlopeInterval { first, n_intervals: 1, ..interval }
}
