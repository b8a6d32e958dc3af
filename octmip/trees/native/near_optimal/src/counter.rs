//! The spectrum of a node: the cuts that trees within the limit may have, their children's spectra, joined.
//!
//! Every tree with a split at the root of a node is one cut, one tree of each side, and not two leaves of one label:
//! the sum over the cuts counts each tree once. A child may cost what the limit leaves beside the least of the other.

use crate::cost::Cost;
use crate::instance::Instance;
use crate::reach::Reach;
use crate::spectrum::{Counts, Spectrum, add, join};
use crate::stumps::{self, Side};
use octmip_exact::{Place, Search, Solved, Switches, View};
use octmip_frame::effort::Control;

/// One thread's counter: the exact core's search and workspaces.
pub struct Counter<'a, T> {
    /// The problem.
    pub(crate) instance: &'a Instance<T>,
    search: Search<'a>,
    /// What is known of the stumps beside the cut that was last placed.
    reach: Reach<T>,
}

impl<'a, T: Cost> Counter<'a, T> {
    /// Workspaces for the nodes of a problem.
    pub fn new(instance: &'a Instance<T>, control: &'a Control, root: &View) -> Self {
        let mut search = Search::new(&instance.samples, Switches::default(), control, instance.depth);
        if instance.depth == 3 && instance.samples.p > 0 && instance.samples.n_labels > 1 {
            search.prepare(root); // every node that follows is a part of it; deeper ones are prepared on the way
        }
        Self { instance, search, reach: Reach::new(instance) }
    }

    /// Whether the count is stopped; what is returned after that is no count.
    pub(crate) fn is_stopped(&self) -> bool {
        self.search.is_stopped()
    }

    /// What trees of one level less than `depth` cost at least on all samples of a node, on the grid.
    pub(crate) fn shallower_bound(&mut self, view: &View, depth: usize, limit: T) -> i64 {
        if depth < 3 || self.instance.samples.p == 0 {
            return 0;
        }
        let upper = self.instance.grid_limit(limit, self.instance.totals_of(view).base);
        if upper > 0 { self.search.shallower_bound(view, depth, upper) } else { 0 }
    }

    /// The cuts of a node that trees of at most `depth` levels (2 or more) up to the limit may have.
    pub(crate) fn cuts(
        &mut self,
        view: &View,
        depth: usize,
        limit: T,
        whole: i64,
        features: std::ops::Range<usize>,
    ) -> Vec<Solved> {
        let upper = self.instance.grid_limit(limit, self.instance.totals_of(view).base);
        self.reach.forget();
        let mut cuts = self.search.cuts_within(view, depth, upper, whole, features).unwrap_or_default();
        cuts.retain(|cut| self.instance.is_own(view, cut));
        cuts.sort_by_key(|cut| (cut.feature, cut.position));
        cuts
    }

    /// All cuts of all features.
    pub(crate) fn all_cuts(&mut self, view: &View, depth: usize, limit: T) -> Vec<Solved> {
        let whole = self.shallower_bound(view, depth, limit);
        self.cuts(view, depth, limit, whole, 0..self.instance.samples.p)
    }

    /// The trees of at most `depth` levels of a node up to the limit.
    pub(crate) fn spectrum(&mut self, view: &View, depth: usize, limit: T) -> Spectrum<T> {
        let totals = self.instance.totals_of(view);
        let mut counts = Counts::new();
        if depth == 1 {
            let sides = [Side { totals: totals.clone(), len: view.len, limit }, Side::empty(self.instance)];
            for f in (0..self.instance.samples.p).filter(|&f| self.instance.fits(self.instance.masks[f])) {
                let mask = self.instance.masks[f];
                stumps::walk(
                    self.instance,
                    f,
                    view.list(f),
                    |_| 0,
                    &sides,
                    |_, _, _, cost| add(&mut counts, cost, mask, 1),
                );
            }
        } else if depth > 1 && limit >= totals.base {
            for cut in self.all_cuts(view, depth, limit) {
                self.count_cut(view, depth, &cut, limit, &mut counts);
            }
        }
        Spectrum::new(counts, &totals, limit)
    }

    /// Count the trees of one cut of a node.
    pub(crate) fn count_cut(&mut self, view: &View, depth: usize, cut: &Solved, limit: T, counts: &mut Counts<T>) {
        let mask = self.instance.masks[cut.feature];
        if let Some([left, right]) = self.sides(view, depth, cut, limit).filter(|_| !self.is_stopped()) {
            join(self.instance, mask, [&left, &right], limit, counts);
        }
    }

    /// Samples left and right of a cut.
    pub(crate) fn split(&self, view: &View, cut: &Solved) -> [View; 2] {
        let mut sides = [View::default(), View::default()];
        let mut marks = vec![false; self.instance.samples.n];
        view.split(&self.instance.samples, cut.feature, cut.position, &mut marks, &mut sides);
        sides
    }

    /// The spectra of both sides of a cut of a node of `depth` levels; None when no tree is within the limit.
    pub(crate) fn sides(&mut self, view: &View, depth: usize, cut: &Solved, limit: T) -> Option<[Spectrum<T>; 2]> {
        if depth <= 2 {
            return self.stump_sides(view, cut, depth, limit);
        }
        let views = self.split(view, cut);
        let base = |side: usize| self.instance.totals_of(&views[side]).base;
        let least = [0, 1].map(|side| self.instance.bound(cut.bounds[side], base(side)));
        let left = self.spectrum(&views[0], depth - 1, limit - self.instance.penalty - least[1]);
        let right = self.spectrum(&views[1], depth - 1, limit - self.instance.penalty - left.least()?);
        Some([left, right])
    }

    /// The same for children of one level or none, without making them.
    fn stump_sides(&mut self, view: &View, cut: &Solved, depth: usize, limit: T) -> Option<[Spectrum<T>; 2]> {
        let sides = self.stump_limits(view, cut, limit);
        let mut counts = [Counts::new(), Counts::new()];
        if depth == 2 {
            let masks = &self.instance.masks;
            self.walk_sides(view, cut, &sides, |f, side, cost| add(&mut counts[side], cost, masks[f], 1));
        }
        let [left, right] = counts;
        Some([
            Spectrum::new(left, &sides[0].totals, sides[0].limit),
            Spectrum::new(right, &sides[1].totals, sides[1].limit),
        ])
    }

    /// Both sides of a cut: what its trees may cost beside the least cost of the other.
    pub(crate) fn stump_limits(&self, view: &View, cut: &Solved, limit: T) -> [Side<T>; 2] {
        let (instance, list) = (self.instance, view.list(cut.feature));
        let parts = [&list[..cut.position], &list[cut.position..]];
        let [left, right] = parts.map(|ids| instance.totals(ids.iter().copied()));
        let least = [instance.bound(cut.bounds[0], left.base), instance.bound(cut.bounds[1], right.base)];
        let rest = limit - instance.penalty;
        [(left, parts[0].len(), rest - least[1]), (right, parts[1].len(), rest - least[0])]
            .map(|(totals, len, limit)| Side { totals, len, limit })
    }

    /// Tell `see` of every stump of both sides within the limits: feature, side, cost.
    ///
    /// Within one node, cuts come in their order: what is known of the stumps beside one bounds those beside the next.
    pub(crate) fn walk_sides(
        &mut self,
        view: &View,
        cut: &Solved,
        sides: &[Side<T>; 2],
        mut see: impl FnMut(usize, usize, T),
    ) {
        let instance = self.instance;
        self.reach.move_to(instance, view, cut);
        let place = Place::new(&instance.samples, view, cut.feature, cut.position, i64::MAX);
        let side_of = |i: u32| usize::from(!place.is_on(0, i));
        for f in (0..instance.samples.p).filter(|&f| instance.fits(instance.masks[f])) {
            if self.reach.may_be_within(f, sides) {
                let more = self.reach.more;
                let see = |side, _, _, cost| see(f, side, cost);
                let least = stumps::walk_beyond(instance, f, view.list(f), side_of, sides, more, see);
                self.reach.set(f, sides, least);
            }
        }
    }
}
