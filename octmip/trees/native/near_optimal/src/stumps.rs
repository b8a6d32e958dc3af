//! The spectrum of trees of at most one split, for both sides of a cut in one walk along every list.
//!
//! At a cut of a side with gains `g` left of it, `G` in all, labels a and b cost `peak - g[a] - (G - g)[b]`. Moving a
//! sample raises `max g + max (G - g)` by its largest gain at most: after a cut that falls short by d, none is looked
//! at before samples of total gain d have passed.

use crate::cost::Cost;
use crate::instance::{Instance, Totals};

/// A side of a cut: its samples' costs, their number, and the most that a tree of it may cost.
#[derive(Debug, Clone)]
pub(crate) struct Side<T> {
    /// Costs of each label.
    pub(crate) totals: Totals<T>,
    /// Number of samples.
    pub(crate) len: usize,
    /// Most that a tree may cost.
    pub(crate) limit: T,
}

impl<T: Cost> Side<T> {
    /// No samples.
    pub(crate) fn empty(instance: &Instance<T>) -> Self {
        Self { totals: instance.totals(std::iter::empty()), len: 0, limit: T::default() }
    }
}

/// What has passed of one side.
#[derive(Debug, Clone)]
struct Passed<T> {
    gains: Vec<T>,
    len: usize,
    rank: u32,
    /// Gain still to pass before a cut can cost less than the cheapest so far, or be within the limit.
    short: T,
}

/// Tell `see` of every split within the limits: side, largest rank that goes left, labels, cost.
pub(crate) fn walk<T: Cost>(
    instance: &Instance<T>,
    f: usize,
    list: &[u32],
    side_of: impl Fn(u32) -> usize,
    sides: &[Side<T>; 2],
    see: impl FnMut(usize, u32, [usize; 2], T),
) {
    walk_beyond(instance, f, list, side_of, sides, T::default(), see);
}

/// The same; for each side the least cost of a split, or of a leaf and the price of one, no more than `more` above its
/// limit.
pub(crate) fn walk_beyond<T: Cost>(
    instance: &Instance<T>,
    f: usize,
    list: &[u32],
    side_of: impl Fn(u32) -> usize,
    sides: &[Side<T>; 2],
    more: T,
    mut see: impl FnMut(usize, u32, [usize; 2], T),
) -> [T; 2] {
    let ranks = instance.samples.ranks_of(f);
    let leaf_size = instance.samples.leaf_size;
    let needs = [0, 1].map(|s| sides[s].totals.peak + instance.penalty - sides[s].limit);
    // A leaf counts as well: it is what a split of more samples may be on these.
    let leaf = |s: usize| sides[s].totals.gains.iter().copied().max().unwrap_or_default();
    let mut shortest = [0, 1].map(|s| more.min(needs[s] - leaf(s)));
    let nothing = Passed { gains: vec![T::default(); instance.n_labels], len: 0, rank: 0, short: T::default() };
    let mut passed = [nothing.clone(), nothing];
    // Of a feature that ranks missing readings above the others, the sides where one is missing: `Instance::is_own`.
    let is_missing = |i: u32| instance.above[f] == Some(ranks[i as usize]);
    let mut has_missing = [instance.above[f].is_none(); 2];
    for &i in list.iter().rev().take_while(|&&i| is_missing(i)) {
        has_missing[side_of(i)] = true;
    }
    for &i in list {
        let s = side_of(i);
        let (side, before) = (&sides[s], &mut passed[s]);
        let rank = ranks[i as usize];
        let is_cut = rank != before.rank && before.len >= leaf_size && side.len - before.len >= leaf_size;
        if is_cut && before.short <= T::default() {
            let cut = before.rank;
            let is_own = has_missing[s] && !is_missing(i);
            let short = look(&before.gains, &side.totals, needs[s], |labels, gain| {
                if is_own {
                    see(s, cut, labels, side.totals.peak + instance.penalty - gain);
                }
            });
            shortest[s] = shortest[s].min(short);
            before.short = short.max(T::default()) - shortest[s].max(T::default());
        }
        before.rank = rank;
        before.len += 1;
        before.short -= instance.ranges[i as usize];
        instance.count(i, &mut before.gains);
    }
    [0, 1].map(|s| sides[s].limit + shortest[s])
}

/// Report the pairs of different labels that gain `need` together; what the best pair of any labels falls short by,
/// negative where it gains more.
#[inline]
fn look<T: Cost>(left: &[T], totals: &Totals<T>, need: T, mut see: impl FnMut([usize; 2], T)) -> T {
    let (mut low, mut high) = (T::default(), T::default());
    for (l, t) in left.iter().zip(&totals.gains) {
        low = low.max(*l);
        high = high.max(*t - *l);
    }
    for a in (0..left.len()).filter(|&a| left[a] + high >= need) {
        for b in (0..left.len()).filter(|&b| b != a) {
            let gain = left[a] + (totals.gains[b] - left[b]);
            if gain >= need {
                see([a, b], gain);
            }
        }
    }
    need - low - high
}
