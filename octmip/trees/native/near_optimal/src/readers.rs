//! For every sensor the least cost of a tree that reads it: the count's walk, with least costs in place of numbers.
//!
//! A split counts as reading only if its sides are not two leaves of one label, as in the count. Of a cut with sides L
//! and R the cheapest tree is therefore the cheapest of: a split left and anything right, anything left and a split
//! right, two leaves of different labels.

use std::sync::Mutex;

use crate::cost::Cost;
use crate::counter::Counter;
use crate::instance::{Instance, Totals};
use crate::run::Run;
use crate::stumps::{self, Side};
use octmip_exact::{Solved, View};
use octmip_frame::control::{KeepGoing, Limits, Stop};
use octmip_frame::effort::Control;

/// Least costs of the trees of some samples, None where none is within the limit.
#[derive(Debug, Clone)]
struct Least<T> {
    leaves: Vec<T>,
    /// Of trees with a split.
    split: Option<T>,
    /// Of trees that read each sensor.
    reading: Vec<Option<T>>,
}

fn lower<T: Cost>(least: &mut Option<T>, cost: T) {
    *least = Some(least.map_or(cost, |known| known.min(cost)));
}

impl<T: Cost> Least<T> {
    fn new(totals: &Totals<T>, n_sensors: usize) -> Self {
        let leaves = (0..totals.gains.len()).map(|label| totals.leaf(label)).collect();
        Self { leaves, split: None, reading: vec![None; n_sensors] }
    }

    fn best(&self) -> Option<T> {
        self.leaves.iter().copied().chain(self.split).min()
    }

    /// Take up a tree of one split.
    fn see(&mut self, sensor: usize, cost: T) {
        lower(&mut self.split, cost);
        lower(&mut self.reading[sensor], cost);
    }

    /// Take up the trees of a cut that reads `sensor`.
    fn join(&mut self, sensor: usize, sides: [&Self; 2], price: T, limit: T) {
        let [left, right] = sides;
        let see = |least: &mut Option<T>, pair: Option<(T, T)>| {
            if let Some(cost) = pair.map(|(l, r)| price + l + r).filter(|cost| *cost <= limit) {
                lower(least, cost);
            }
        };
        let mut whole = None;
        see(&mut whole, left.split.zip(right.best()));
        see(&mut whole, left.best().zip(right.split));
        for (a, l) in left.leaves.iter().enumerate() {
            for (_, r) in right.leaves.iter().enumerate().filter(|(b, _)| *b != a) {
                see(&mut whole, Some((*l, *r)));
            }
        }
        if let Some(cost) = whole {
            lower(&mut self.split, cost);
            lower(&mut self.reading[sensor], cost);
        }
        for (s, least) in self.reading.iter_mut().enumerate() {
            see(least, left.reading[s].zip(right.best()));
            see(least, left.best().zip(right.reading[s]));
        }
    }
}

impl<T: Cost> Counter<'_, T> {
    fn least(&mut self, view: &View, depth: usize, limit: T) -> Least<T> {
        let totals = self.instance.totals_of(view);
        let mut least = Least::new(&totals, self.instance.n_sensors);
        if depth == 1 {
            let sides = [Side { totals, len: view.len, limit }, Side::empty(self.instance)];
            for f in 0..self.instance.samples.p {
                let sensor = self.instance.sensors[f];
                stumps::walk(self.instance, f, view.list(f), |_| 0, &sides, |_, _, _, cost| least.see(sensor, cost));
            }
        } else if depth > 1 && limit >= totals.base {
            for cut in self.all_cuts(view, depth, limit) {
                self.least_of_cut(view, depth, &cut, limit, &mut least);
            }
        }
        least
    }

    fn least_of_cut(&mut self, view: &View, depth: usize, cut: &Solved, limit: T, least: &mut Least<T>) {
        let instance = self.instance;
        let (price, sensor) = (instance.penalty, instance.sensors[cut.feature]);
        if depth <= 2 {
            let sides = self.stump_limits(view, cut, limit);
            let [mut left, mut right] = [0, 1].map(|s| Least::new(&sides[s].totals, instance.n_sensors));
            if depth == 2 {
                let mut found = [&mut left, &mut right];
                let sensors = &instance.sensors;
                self.walk_sides(view, cut, &sides, |f, side, cost| found[side].see(sensors[f], cost));
            }
            return least.join(sensor, [&left, &right], price, limit);
        }
        let views = self.split(view, cut);
        let bound = |side: usize| instance.bound(cut.bounds[side], instance.totals_of(&views[side]).base);
        let limits = [limit - price - bound(1), limit - price - bound(0)];
        let [left, right] = [0, 1].map(|side| self.least(&views[side], depth - 1, limits[side]));
        least.join(sensor, [&left, &right], price, limit);
    }
}

/// The least cost of a tree that reads each sensor, where it is less than what is known, and why the search ended.
pub fn least_by_sensor<T: Cost>(
    instance: &Instance<T>,
    known: &[T],
    n_threads: usize,
    limits: Limits,
    keep_going: KeepGoing<'_>,
) -> (Vec<Option<T>>, Option<Stop>, u64) {
    let one = T::from_grid(1, 0);
    let highest = |best: &[T]| best.iter().copied().max().unwrap_or_default() - one;
    let run = Run::new(instance, highest(known), n_threads, limits);
    if instance.depth == 1 {
        let control = Control::new();
        let least = Counter::new(instance, &control, &run.root).least(&run.root, 1, run.limit);
        return (better(&least.reading, known), None, 0);
    }
    let (cuts, open) = run.root_cuts(&mut *keep_going);
    let best = Mutex::new(known.to_vec());
    let base = instance.totals_of(&run.root).base;
    let root = &run.root;
    let done = run.each(cuts.len(), &mut *keep_going, |counter, k| {
        // A tree that is no cheaper than what is known for every sensor is of no use.
        let limit = best.lock().map_or(run.limit, |best| highest(&best));
        let mut least = Least::new(&instance.totals_of(root), instance.n_sensors);
        if instance.bound(cuts[k].bounds[0] + cuts[k].bounds[1], base) + instance.penalty <= limit {
            counter.least_of_cut(root, instance.depth, &cuts[k], limit, &mut least);
        }
        if let Ok(mut best) = best.lock() {
            for (known, cost) in best.iter_mut().zip(&least.reading) {
                *known = cost.map_or(*known, |cost| cost.min(*known));
            }
        }
    });
    let is_whole = open.is_empty() && done.iter().all(Option::is_some);
    let stop = if is_whole { None } else { Some(run.stop()) };
    let best: Vec<_> = best.into_inner().unwrap_or_default().into_iter().map(Some).collect();
    (better(&best, known), stop, run.n_evaluated())
}

fn better<T: Cost>(found: &[Option<T>], known: &[T]) -> Vec<Option<T>> {
    found.iter().zip(known).map(|(found, known)| found.filter(|cost| cost < known)).collect()
}
