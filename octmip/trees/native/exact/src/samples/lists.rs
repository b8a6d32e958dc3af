//! Lists of all samples in the order of a feature, made when they are asked for.
//!
//! A search of at most two levels never parts its samples, and looks at one feature after the other. So a list need not
//! stay while others are looked at, but for those of features whose buckets are walked: 4 bytes a value less.

use std::sync::{Arc, OnceLock};

use crate::samples::Samples;
use octmip_frame::ranks::sorted_by_rank;

/// The lists of all samples of a problem.
#[derive(Debug, Clone)]
pub(crate) struct ListsOnDemand {
    ranks: Arc<Vec<u32>>,
    n: usize,
    /// Whether each sample is in the lists; None: all are.
    is_here: Option<Arc<Vec<bool>>>,
    kept: Arc<Vec<OnceLock<Vec<u32>>>>,
    /// The feature that is looked at, and its list.
    held: Option<(usize, Arc<Vec<u32>>)>,
}

impl ListsOnDemand {
    /// No list yet.
    pub(crate) fn new(samples: &Samples) -> Self {
        Self { ranks: samples.ranks.clone(), n: samples.n, is_here: None, kept: unmade(samples.p), held: None }
    }

    /// The lists of some of the samples.
    pub(crate) fn part(&self, is_here: Vec<bool>) -> Self {
        let (ranks, kept) = (self.ranks.clone(), unmade(self.kept.len()));
        Self { ranks, n: self.n, is_here: Some(Arc::new(is_here)), kept, held: None }
    }

    /// The samples by id.
    pub(crate) fn ids(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.n as u32).filter(|&i| self.has(i))
    }

    fn has(&self, i: u32) -> bool {
        self.is_here.as_ref().is_none_or(|is_here| is_here[i as usize])
    }

    /// The list of a feature, kept from now on unless it is held.
    pub(crate) fn kept(&self, f: usize) -> &[u32] {
        match &self.held {
            Some((held, list)) if *held == f => list,
            _ => self.kept[f].get_or_init(|| self.made(f)),
        }
    }

    /// The same lists, that of a feature at hand as long as they live.
    pub(crate) fn holding(&self, f: usize) -> Self {
        let is_held = self.held.as_ref().is_some_and(|(held, _)| *held == f);
        let held = if is_held { self.held.clone() } else { Some((f, Arc::new(self.made(f)))) };
        Self { held, ..self.clone() }
    }

    /// The list that is held.
    pub(crate) fn held(&self) -> &[u32] {
        self.held.as_ref().map_or(&[], |(_, list)| list)
    }

    fn made(&self, f: usize) -> Vec<u32> {
        if let Some(list) = self.kept[f].get() {
            return list.clone();
        }
        let ranks = &self.ranks[f * self.n..(f + 1) * self.n];
        let mut list = sorted_by_rank(ranks, ranks.iter().max().map_or(0, |most| most + 1));
        list.retain(|&i| self.has(i));
        list
    }
}

fn unmade(p: usize) -> Arc<Vec<OnceLock<Vec<u32>>>> {
    Arc::new((0..p).map(|_| OnceLock::new()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::View;
    use octmip_oracle::problem_of_ranks;

    #[test]
    fn lists_on_demand_are_those_of_all_samples() {
        let problem = problem_of_ranks(&[2, 0, 1, 0, 2, 1, 0, 0, 1, 0], &[0, 1, 0, 1, 1]);
        let (whole, samples) = (Samples::new(&problem), Samples::without_order(&problem));
        let (known, view) = (View::root(&whole), View::root(&samples));
        assert!(samples.order.is_empty());
        let held = view.holding(1).expect("lists are made on demand");
        for f in 0..2 {
            assert_eq!(held.list(f), known.list(f));
            view.with_list(f, |list| assert_eq!(list, known.list(f)));
            let [some, all] = [&view, &known].map(|view| view.side(&whole, f, 2, 1));
            assert_eq!((some.list(1 - f), some.totals.clone()), (all.list(1 - f), all.totals.clone()));
            assert_eq!(some.ids(&samples).count(), 3);
        }
    }
}
