//! The two sides of a moving cut, as the scans of other features read them.

use crate::clusters::Sums;
use crate::quantiles::Ranked;
use crate::samples::Samples;
use crate::view::View;

/// Which side each sample of a node lies on, and what each side sums to.
#[derive(Debug, Default)]
pub(crate) struct Sides {
    /// 0 left, 1 right, by sample id.
    pub(crate) of_sample: Vec<u8>,
    /// Sums of both sides.
    pub(crate) sums: [Sums; 2],
    /// Samples of both sides.
    pub(crate) counts: [usize; 2],
    /// Samples of both sides in the order of their targets, of sloped errors: of the cut where `is_ranked`.
    pub(crate) ranked: [Ranked; 2],
    /// Twice the place of each sample there, and its side; by sample id.
    pub(crate) keys: Vec<u32>,
    is_ranked: bool,
}

impl Sides {
    /// Room for so many samples.
    pub(crate) fn new(n: usize) -> Self {
        Self { of_sample: vec![1; n], keys: vec![0; n], ..Self::default() }
    }

    /// Take up a node, or come back to its beginning: all samples on the right.
    pub(crate) fn rewind(&mut self, samples: &Samples, view: &View) {
        self.is_ranked = false;
        self.sums = [Sums::default(), view.sums(samples)];
        self.counts = [0, view.len];
        for &i in view.list(samples.p) {
            self.of_sample[i as usize] = 1;
        }
    }

    /// Put the samples of both sides in the order of their targets.
    pub(crate) fn rank(&mut self, samples: &Samples, view: &View) {
        if std::mem::replace(&mut self.is_ranked, true) {
            return;
        }
        self.ranked.iter_mut().for_each(Ranked::clear);
        for &i in view.list(samples.p) {
            let i = i as usize;
            let side = self.of_sample[i];
            let place = self.ranked[usize::from(side)].push(samples.targets[i], samples.sums[i].weight);
            self.keys[i] = 2 * place + u32::from(side);
        }
        self.ranked.iter_mut().for_each(Ranked::end);
    }

    /// Bring the cut of feature `f` to so many samples on the left; `passed` is called for each that changes sides.
    pub(crate) fn move_to(
        &mut self,
        samples: &Samples,
        view: &View,
        f: usize,
        k: usize,
        mut passed: impl FnMut(u32, usize),
    ) {
        self.is_ranked &= self.counts[0] == k;
        let list = view.list(f);
        while self.counts[0] != k {
            let (place, to) = if self.counts[0] < k { (self.counts[0], 0) } else { (self.counts[0] - 1, 1) };
            self.pass(samples, list[place], to);
            passed(list[place], to);
        }
        if k == 0 {
            (self.sums[1], self.sums[0]) = (view.sums(samples), Sums::default());
        }
    }

    #[inline]
    fn pass(&mut self, samples: &Samples, i: u32, to: usize) {
        let own = samples.sums[i as usize];
        self.of_sample[i as usize] = to as u8;
        self.sums[to] += own;
        self.sums[1 - to] = self.sums[1 - to] - own;
        self.counts[to] += 1;
        self.counts[1 - to] -= 1;
    }
}
