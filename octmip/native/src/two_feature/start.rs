//! First trees: root and children improved in turn, each exactly with the others fixed, from many random roots.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use super::boxes::Field;
use super::chart::REGIONS;
use super::extract::Sketch;
use super::loss::{INFEASIBLE, Loss};
use super::strips::Strip;
use super::stump::{Question, best_split};
use super::view::{Line, View};

/// Strips looked at in one move, and regions of them that are split.
const STRIPS: usize = 64;
const TRIED: usize = 8;
const MOST_ROUNDS: usize = 8;

/// A random number generator (an LCG's upper bits: plenty for choosing strips).
struct Draws(u64);

impl Draws {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) as usize) % n
    }
}

/// The best tree of depth 2 found from random roots within the charts of `strips`, until `patience` in a row fail.
pub fn first_tree(
    field: &Field<'_>,
    strips: &Arc<Vec<Strip>>,
    patience: usize,
    seed: u64,
    floor: i64,
) -> Option<(i64, Sketch)> {
    let mut draws = Draws(seed ^ 0x9e37_79b9_7f4a_7c15);
    let mut best: Option<(i64, Sketch)> = None;
    let mut n_vain = 0;
    while n_vain < patience {
        n_vain += 1;
        let is_done = best.as_ref().is_some_and(|(cost, _)| *cost <= floor);
        if is_done || field.stop.load(Ordering::Relaxed) || strips.is_empty() {
            break;
        }
        let strip = one_of(strips[draws.below(strips.len())], &mut draws);
        let chart = &field.charts[strip.chart as usize];
        let (k, region) = (strip.first as usize, 4 + draws.below(REGIONS - 8));
        let cell = chart.cell((k, k + 1), (region, region + 1));
        let (t, r) = cell.center();
        let mut line = Line { features: chart.features, t, r };
        let mut last = INFEASIBLE;
        for _ in 0..MOST_ROUNDS {
            let children = field.best_children(line, strips, &mut draws);
            let cost = children[0].0 + children[1].0 + field.ground.view().price(line.features);
            if cost >= last {
                break;
            }
            last = cost;
            let stumps = children.map(|(_, line)| line);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                let sketches = stumps.map(Sketch::stump);
                best = Some((cost, Sketch::Split(line, Box::new(sketches))));
                n_vain = 0;
            }
            match field.move_root(line, stumps, strips, &mut draws) {
                Some(moved) => line = moved,
                None => break,
            }
        }
    }
    best
}

impl Field<'_> {
    fn sides(&self, line: Line) -> [Vec<u32>; 2] {
        let plane = &self.ground.plane;
        let (left, right) = self.all.iter().partition(|&&i| line.sends_left(plane, i));
        [left, right]
    }

    fn best_children(&self, root: Line, strips: &[Strip], draws: &mut Draws) -> [(i64, Option<Line>); 2] {
        self.sides(root).map(|ids| {
            let question = Question {
                ids: &ids,
                need: self.ground.loss.leaf_size as i64,
                cutoff: INFEASIBLE,
                floor: 0,
                most_tried: TRIED,
                hopeless: 0,
                dead: INFEASIBLE,
                less: 0,
            };
            let mut chosen = some_strips(strips, draws);
            let view = self.ground.view();
            let answer = best_split(view, &self.charts, question, [], &mut chosen, self.stop);
            (answer.attained, answer.line)
        })
    }

    /// The root that sends most weight to the child that does better by it.
    fn move_root(&self, root: Line, children: [Option<Line>; 2], strips: &[Strip], draws: &mut Draws) -> Option<Line> {
        let sides = self.sides(root);
        let costs = [0, 1].map(|s| self.costs_under(children[s], &sides[s]));
        let labels: Vec<u32> = (0..self.all.len()).map(|i| u32::from(costs[1][i] < costs[0][i])).collect();
        let weights: Vec<i64> = (0..self.all.len()).map(|i| (costs[1][i] - costs[0][i]).abs()).collect();
        let loss = Loss::two_sides();
        let matter: Vec<u32> = self.all.iter().copied().filter(|&i| weights[i as usize] > 0).collect();
        let view = View {
            plane: &self.ground.plane,
            labels: &labels,
            weights: &weights,
            loss: &loss,
            switches: self.ground.switches,
        };
        let question = Question {
            ids: &matter,
            need: 1,
            cutoff: INFEASIBLE,
            floor: 0,
            most_tried: TRIED,
            hopeless: 0,
            dead: INFEASIBLE,
            less: 0,
        };
        let mut chosen = some_strips(strips, draws);
        best_split(view, &self.charts, question, [root], &mut chosen, self.stop).line
    }

    /// What every sample costs under a child whose labels are the best for its own samples.
    fn costs_under(&self, child: Option<Line>, own: &[u32]) -> Vec<i64> {
        let (view, plane) = (self.ground.view(), &self.ground.plane);
        let goes_left = |i: u32| child.is_none_or(|line| line.sends_left(plane, i));
        let (left, right): (Vec<u32>, Vec<u32>) = own.iter().partition(|&&i| goes_left(i));
        let labels = [left, right].map(|ids| view.loss.leaf(&view.tally(&ids)).1);
        self.all
            .iter()
            .map(|&i| {
                let label = labels[usize::from(!goes_left(i))];
                let class = view.labels[i as usize] as usize;
                view.weights[i as usize] * view.loss.cost(class, label)
            })
            .collect()
    }
}

fn some_strips(strips: &[Strip], draws: &mut Draws) -> Vec<Strip> {
    let n_strips: usize = strips.iter().map(|strip| strip.n_strips as usize).sum();
    if n_strips <= STRIPS {
        return strips.to_vec();
    }
    (0..STRIPS).map(|_| one_of(strips[draws.below(strips.len())], draws)).collect()
}

fn one_of(strip: Strip, draws: &mut Draws) -> Strip {
    let first = strip.first + draws.below(strip.n_strips as usize) as u16;
    Strip { first, n_strips: 1, ..strip }
}
