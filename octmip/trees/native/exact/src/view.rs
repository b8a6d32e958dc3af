//! The samples that reach a node: one list of ids per feature, each in the order of that feature.

use std::sync::Arc;

use crate::samples::Samples;
use crate::samples::lists::ListsOnDemand;
use octmip_frame::interval::part;

/// Samples of a node. The cut at position `k` of feature `f` sends the first `k` samples of list `f` left.
#[derive(Debug, Clone, Default)]
pub struct View {
    /// Number of samples.
    pub len: usize,
    /// Sample ids, list after list (`p * len`); those of all samples are shared.
    pub(crate) lists: Arc<Vec<u32>>,
    /// The lists of all samples, where they are made when they are asked for; `lists` is empty then.
    on_demand: Option<ListsOnDemand>,
    /// Gain of predicting each label for all of them (`n_labels`).
    pub(crate) totals: Vec<i64>,
    /// Sum of their cost ranges.
    pub(crate) total_range: i64,
}

impl View {
    /// All the samples.
    pub fn root(samples: &Samples) -> Self {
        let on_demand = samples.order.is_empty().then(|| ListsOnDemand::new(samples));
        let mut view = Self { len: samples.n, lists: samples.order.clone(), on_demand, ..Self::default() };
        view.recount(samples, 0..samples.n as u32);
        view
    }

    /// The samples of `ids`, none twice.
    pub(crate) fn subset(samples: &Samples, ids: &[u32]) -> Self {
        let mut chosen = vec![false; samples.n];
        for &i in ids {
            chosen[i as usize] = true;
        }
        let lists = Arc::new(samples.order.iter().copied().filter(|&i| chosen[i as usize]).collect());
        let mut view = Self { len: ids.len(), lists, ..Self::default() };
        view.recount(samples, ids.iter().copied());
        view
    }

    /// The samples in the order of feature `f`.
    pub fn list(&self, f: usize) -> &[u32] {
        match &self.on_demand {
            Some(lists) => lists.kept(f),
            None => &self.lists[f * self.len..(f + 1) * self.len],
        }
    }

    /// Use the samples in the order of feature `f` once: no list is kept for it.
    pub(crate) fn with_list<R>(&self, f: usize, used: impl FnOnce(&[u32]) -> R) -> R {
        match &self.on_demand {
            Some(lists) => used(lists.holding(f).held()),
            None => used(self.list(f)),
        }
    }

    /// The same view while the list of feature `f` is asked for many times; None where all lists are there.
    pub(crate) fn holding(&self, f: usize) -> Option<Self> {
        let lists = self.on_demand.as_ref()?;
        Some(Self { on_demand: Some(lists.holding(f)), ..self.clone() })
    }

    /// Use all sample ids, in some order.
    pub(crate) fn with_ids<R>(&self, used: impl FnOnce(&[u32]) -> R) -> R {
        match &self.on_demand {
            Some(lists) => used(&lists.ids().collect::<Vec<u32>>()),
            None => used(self.list(0)),
        }
    }

    /// All sample ids, in some order.
    pub fn ids<'a>(&'a self, samples: &Samples) -> Box<dyn Iterator<Item = u32> + 'a> {
        match &self.on_demand {
            Some(lists) => Box::new(lists.ids()),
            None if samples.p == 0 => Box::new(0..self.len as u32), // without features nothing is ever split
            None => Box::new(self.list(0).iter().copied()),
        }
    }

    /// Added cost of the best leaf.
    pub(crate) fn leaf(&self) -> i64 {
        self.total_range - self.totals.iter().copied().max().unwrap_or(0)
    }

    /// The label of the best leaf, the lowest among equals.
    pub(crate) fn best_label(&self) -> usize {
        first_largest(&self.totals)
    }

    /// The samples on one side of the cut at position `k` of feature `f`.
    pub(crate) fn side(&self, samples: &Samples, f: usize, k: usize, side: usize) -> Self {
        let (mut view, is_here) = self.totals_of_side(samples, f, k, side);
        match &self.on_demand {
            Some(lists) => view.on_demand = Some(lists.part(is_here)),
            None => view.lists = Arc::new(self.lists.iter().copied().filter(|&i| is_here[i as usize]).collect()),
        }
        view
    }

    /// The same without lists, and which of all samples (`n`) are in it.
    pub(crate) fn totals_of_side(&self, samples: &Samples, f: usize, k: usize, side: usize) -> (Self, Vec<bool>) {
        let mut is_here = vec![false; samples.n];
        let mut view = Self::default();
        self.with_list(f, |list| {
            let ids = if side == 0 { &list[..k] } else { &list[k..] };
            ids.iter().for_each(|&i| is_here[i as usize] = true);
            view.len = ids.len();
            view.recount(samples, ids.iter().copied());
        });
        (view, is_here)
    }

    /// Fill `sides` with the samples left and right of the cut at position `k` of feature `f`.
    pub fn split(&self, samples: &Samples, f: usize, k: usize, marks: &mut [bool], sides: &mut [View; 2]) {
        for (position, &i) in self.list(f).iter().enumerate() {
            marks[i as usize] = position >= k;
        }
        let sizes = [k, self.len - k];
        let lists = sides.each_mut().map(|view| Arc::make_mut(&mut view.lists));
        part(samples.p, (self.len, k), |g| self.list(g), marks, lists);
        for (side, view) in sides.iter_mut().enumerate() {
            view.len = sizes[side];
            let ids = if side == 0 { &self.list(f)[..k] } else { &self.list(f)[k..] };
            view.recount(samples, ids.iter().copied());
        }
    }

    fn recount(&mut self, samples: &Samples, ids: impl Iterator<Item = u32>) {
        self.totals.clear();
        self.totals.resize(samples.n_labels, 0);
        self.total_range = 0;
        for i in ids {
            samples.count(i, 1, &mut self.totals);
            self.total_range += samples.ranges[i as usize];
        }
    }
}

/// The first of the largest numbers.
pub(crate) fn first_largest(numbers: &[i64]) -> usize {
    (0..numbers.len()).rev().max_by_key(|&k| numbers[k]).unwrap_or(0)
}
