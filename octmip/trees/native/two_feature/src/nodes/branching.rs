//! Branching: a node is bounded, solved by its dichotomies or split.

use std::sync::atomic::Ordering;

use crate::geometry::line::Line;
use crate::line_tree::LineTree;
use crate::nodes::known::{Known, Notes};
use crate::nodes::node::{Goal, Node, Partition, Processed, SearchContext};
use crate::regions::dichotomies::{Dichotomies, End, end_of};
use crate::regions::realisation::{CLEARANCE, Realisation, Separability, realise};
use crate::regions::region::split;
use crate::stumps::search::{StumpResult, StumpTask};

impl SearchContext<'_> {
    /// Bound a node until `target`, split it if that fails; trees of `upper` and more are of no interest.
    pub(crate) fn process(&self, mut root: Node, target: i64, upper: i64, known: &Known) -> Processed {
        let features = self.dual_planes[root.dual_plane as usize].features;
        let partition = self.partition(features, &root.region);
        let (mut done, mut notes) = (Processed::default(), Notes::new(known));
        if self.is_infeasible(&partition) {
            return done;
        }
        self.try_center(&root, &partition, upper, &mut done);
        let upper = done.found.as_ref().map_or(upper, |(cost, _)| *cost);
        let goal = Goal { target: target.min(upper), upper };
        self.bound(&mut root, &partition, goal, &mut notes);
        if root.key >= goal.target {
            done.lessons = notes.lessons;
            if root.key < upper {
                done.nodes.push(root);
            }
            return done;
        }
        let plane = &self.instance.plane;
        let end = end_of(plane, features, &root.region, &partition.open);
        if let End::Parts { points, dichotomies } = &end {
            self.solve_dichotomies(&mut root, &partition, (points, dichotomies), upper, &mut done, &mut notes);
            done.lessons = notes.lessons;
            return done;
        }
        if end == End::Stuck {
            done.lessons = notes.lessons;
            done.undecided = Some(root.key);
            return done;
        }
        self.learn_gains(&mut root, &partition, &notes);
        done.lessons = notes.lessons;
        let dual_plane = &self.dual_planes[root.dual_plane as usize];
        let at = dual_plane.middle_boundary(root.region.t0, root.region.t1);
        for region in split(plane, features, &root.region, &partition.open, at) {
            done.nodes.push(Node { region, ..root.clone() });
        }
        done
    }

    /// Try the root line in the middle of the region with the splits kept for the children.
    fn try_center(&self, root: &Node, partition: &Partition, upper: i64, done: &mut Processed) {
        let features = self.dual_planes[root.dual_plane as usize].features;
        let (t, r) = root.region.center();
        let line = Line { features, t, r };
        let mut sides = partition.sides.clone();
        for &i in &partition.open {
            sides[usize::from(!line.sends_left(&self.instance.plane, i))].push(i);
        }
        let is_one_sided = sides.iter().any(Vec::is_empty);
        if is_one_sided || !line.is_clear_of(&self.instance.plane, &partition.open) {
            return;
        }
        let samples = self.instance.samples();
        let best = [0, 1]
            .map(|s| self.incumbent(root.children[s].lines.iter(), &sides[s], &samples.tally(&sides[s]), self.need()));
        let cost = best[0].0 + best[1].0 + self.price(root);
        if cost < upper {
            let children = best.map(|(_, line)| LineTree::stump(line));
            done.found = Some((cost, LineTree::Split(line, Box::new(children))));
        }
    }

    /// Solve every dichotomy of the open points by a root line of the region.
    fn solve_dichotomies(
        &self,
        root: &mut Node,
        partition: &Partition,
        (points, dichotomies): (&[Vec<u32>], &Dichotomies),
        mut upper: i64,
        done: &mut Processed,
        notes: &mut Notes<'_>,
    ) {
        let features = self.dual_planes[root.dual_plane as usize].features;
        let plane = &self.instance.plane;
        for dichotomy in dichotomies.iter() {
            if self.stop.load(Ordering::Relaxed) {
                return;
            }
            let chosen = |wanted: bool| points.iter().zip(&dichotomy).filter(move |(_, w)| **w == wanted);
            let first = |wanted| chosen(wanted).map(|(p, _)| p[0]).collect::<Vec<u32>>();
            let (distance, ..) = root.region.clearest(plane, features, &first(true), &first(false));
            // No line of the region leaves room for it; where one outside does, its own region finds it.
            if distance < -CLEARANCE && self.instance.switches.room {
                continue;
            }
            let sides = partition.with(points, &dichotomy);
            let Some((lower, results)) = self.solve_sides(root, &sides, upper, notes) else {
                continue;
            };
            let incumbent = results[0].incumbent + results[1].incumbent + self.price(root);
            match realise(plane, features, &root.region, &self.all, (points, &dichotomy), &mut Separability::new()) {
                Realisation::Never => continue,
                Realisation::Line(line) if incumbent < upper => {
                    let children = results.map(|result| LineTree::stump(result.line));
                    done.found = Some((incumbent, LineTree::Split(line, Box::new(children))));
                    upper = incumbent;
                }
                _ => {}
            }
            if lower < upper {
                done.undecided = Some(done.undecided.map_or(lower, |undecided| undecided.min(lower)));
            }
        }
    }

    /// Solve both children of a fixed root; None if the tree is not below `upper`.
    fn solve_sides(
        &self,
        root: &mut Node,
        sides: &[Vec<u32>; 2],
        upper: i64,
        notes: &mut Notes<'_>,
    ) -> Option<(i64, [StumpResult; 2])> {
        let (floors, results) = self.side_bounds(root, sides, upper, notes);
        let lower = floors[0] + floors[1] + self.price(root);
        match results {
            [Some(left), Some(right)] if lower < upper => Some((lower, [left, right])),
            _ => None,
        }
    }

    /// Bounds of both children of a fixed root until the tree reaches `upper`, and the results that gave them.
    pub(crate) fn side_bounds(
        &self,
        root: &mut Node,
        sides: &[Vec<u32>; 2],
        upper: i64,
        notes: &mut Notes<'_>,
    ) -> ([i64; 2], [Option<StumpResult>; 2]) {
        let price = self.price(root);
        let mut floors = [0, 1].map(|s| {
            let tally = self.instance.samples().tally(&sides[s]);
            root.children[s].floor.max(self.two_labels(&tally)).max(notes.at_least([&sides[s], &[]]))
        });
        let mut results = [None, None];
        // The larger side first: it reaches its cutoff more often.
        let first = usize::from(sides[1].len() > sides[0].len());
        for s in [first, 1 - first] {
            if floors[0] + floors[1] + price >= upper {
                break;
            }
            let cutoff = upper - price - floors[1 - s];
            let task = StumpTask {
                ids: &sides[s],
                need: self.need(),
                cutoff,
                floor: floors[s],
                most_tried: usize::MAX,
                hopeless: 0,
                dead: cutoff,
                less: 0,
                most: None,
            };
            let mut intervals = root.children[s].intervals.to_vec();
            let result = self.solve_stump(&root.children[s], task, &mut intervals);
            root.children[s].remember(result.line);
            notes.add([&sides[s], &[]], result.lower.min(root.children[s].struck), result.line);
            floors[s] = result.lower;
            results[s] = Some(result);
        }
        (floors, results)
    }
}
