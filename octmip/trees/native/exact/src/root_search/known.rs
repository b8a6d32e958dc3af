//! State of a search, small enough to be kept: the solved cuts of the root, and the best tree.
//!
//! A later search takes it up where it was left. It believes the bounds of the cuts, which it could only check by the
//! work that made them; what a glance can refute is refused (`Known::check`).

use std::time::Instant;

use crate::node::result::{FeatureIncumbent, Solved};
use crate::samples::Samples;
use crate::view::View;
use octmip_frame::tree::Tree;

/// Sensors that a node of the search over sensor sets holds and bans.
pub type Held = (Vec<bool>, Vec<bool>);

/// Proven bounds and best tree of a search. Costs are above the base, in a file but that of the tree.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Levels of the trees whose root was searched, 3 or more; those of fewer levels are done.
    pub level: usize,
    /// Lower bound of the trees of one level fewer on all samples.
    pub whole: i64,
    /// Incumbent of each feature one level lower, which orders the features (`p`, or none).
    pub order: Vec<FeatureIncumbent>,
    /// Incumbent of each feature at this level (`p`).
    pub incumbents: Vec<FeatureIncumbent>,
    /// Solved cuts of the root.
    pub cuts: Vec<Solved>,
    /// Lower bound of all trees without the budget of sensors.
    pub bound: i64,
    /// Best tree; while sensor sets are not searched yet it may break the budget.
    pub best: (i64, Tree),
    /// Cuts evaluated by this search.
    pub n_nodes: u64,
    /// Open nodes of the search over sensor sets, once it has begun.
    pub sets: Option<Vec<Held>>,
}

impl Known {
    /// The same in another unit.
    pub(crate) fn map_costs(mut self, to: impl Fn(i64) -> i64) -> Self {
        let mapped = |incumbent: &mut FeatureIncumbent| {
            if incumbent.cost != FeatureIncumbent::NOTHING.cost {
                incumbent.cost = to(incumbent.cost);
            }
        };
        self.order.iter_mut().chain(&mut self.incumbents).for_each(mapped);
        self.cuts.iter_mut().for_each(|cut| cut.bounds = cut.bounds.map(&to));
        (self.whole, self.bound, self.best.0) = (to(self.whole), to(self.bound), to(self.best.0));
        self
    }

    /// The same with so much less in the cost of its tree.
    pub(crate) fn without(mut self, base: i64) -> Self {
        self.best.0 -= base;
        self
    }

    /// Refuse what cannot be: numbers out of range, cuts that are none, bounds above what one leaf costs.
    pub(crate) fn check(&self, samples: &Samples, view: &View, depth: usize, n_sensors: usize) -> Result<(), String> {
        let p = samples.p;
        let is_order = self.order.is_empty() || self.order.len() == p;
        if !(3..=depth).contains(&self.level) || !is_order || self.incumbents.len() != p {
            return Err(format!("level {} of {depth}, {} features of {p}", self.level, self.incumbents.len()));
        }
        let leaf = view.leaf();
        if !(0..=leaf).contains(&self.whole) || !(0..=self.best.0).contains(&self.bound) {
            return Err(format!("bounds {} and {}, where one leaf costs {leaf}", self.whole, self.bound));
        }
        let is_set = |(held, banned): &Held| held.len() == n_sensors && banned.len() == n_sensors;
        if !self.sets.iter().flatten().all(is_set) {
            return Err(format!("a set of sensors is not one of {n_sensors}"));
        }
        let mut cuts = self.cuts.clone();
        cuts.sort_by_key(|cut| (cut.feature, cut.position));
        cuts.chunk_by(|a, b| a.feature == b.feature).try_for_each(|cuts| check_feature(cuts, samples, view))
    }
}

/// Check the cuts of one feature, ascending.
fn check_feature(cuts: &[Solved], samples: &Samples, view: &View) -> Result<(), String> {
    let feature = cuts[0].feature;
    if feature >= samples.p {
        return Err(format!("feature {feature} of {}", samples.p));
    }
    let (list, ranks) = (view.list(feature), samples.ranks_of(feature));
    let (mut totals, mut total_range, mut joined) = (vec![0; samples.n_labels], 0, 0);
    for cut in cuts {
        let k = cut.position;
        let splits = k > 0 && k < view.len && ranks[list[k - 1] as usize] != ranks[list[k] as usize];
        if !splits {
            return Err(format!("feature {feature} has no cut at {k}"));
        }
        for &i in &list[joined..k] {
            samples.count(i, 1, &mut totals);
            total_range += samples.ranges[i as usize];
        }
        joined = k;
        let saved = |gains: &mut dyn Iterator<Item = i64>| gains.max().unwrap_or(0);
        let left = total_range - saved(&mut totals.iter().copied());
        let right =
            view.total_range - total_range - saved(&mut view.totals.iter().zip(&totals).map(|(all, left)| all - left));
        let [low, high] = cut.bounds;
        if !(0..=left).contains(&low) || !(0..=right).contains(&high) {
            return Err(format!(
                "cut {k} of feature {feature} has bounds {low} and {high}; leaves cost {left}, {right}"
            ));
        }
    }
    Ok(())
}

/// Taker of what is known, every so often.
pub struct Saver<'a> {
    /// Seconds between two times.
    pub every: f64,
    /// Takes it; `false` means stop now.
    pub save: &'a mut dyn FnMut(&Known) -> bool,
}

/// A saver, and when it was last given something.
pub(crate) struct Due<'a> {
    saver: Option<Saver<'a>>,
    saved: Instant,
}

impl Default for Due<'_> {
    fn default() -> Self {
        Self::new(None)
    }
}

impl<'a> Due<'a> {
    /// Next due after the saver's interval from now.
    pub(crate) fn new(saver: Option<Saver<'a>>) -> Self {
        Self { saver, saved: Instant::now() }
    }

    /// Hand out what is known, now or if it is time; whether to go on.
    pub(crate) fn save(&mut self, now: bool, known: &dyn Fn() -> Known) -> bool {
        let Some(saver) = &mut self.saver else { return true };
        if !now && self.saved.elapsed().as_secs_f64() < saver.every {
            return true;
        }
        let goes_on = (saver.save)(&known());
        self.saved = Instant::now();
        goes_on
    }
}
