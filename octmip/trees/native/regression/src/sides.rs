//! The two sides of a moving cut, as the scans of other features read them.

use crate::clusters::Sums;
use crate::quantiles::Targets;
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
    /// Targets of both sides, as indices of `values`; of sloped errors only.
    pub(crate) targets: [Targets; 2],
    /// Index of each sample's target in `values`, by sample id.
    pub(crate) target_of: Vec<u32>,
    /// The node's distinct targets, ascending.
    pub(crate) values: Vec<f64>,
}

impl Sides {
    /// Room for so many samples.
    pub(crate) fn new(n: usize) -> Self {
        Self { of_sample: vec![1; n], target_of: vec![0; n], ..Self::default() }
    }

    /// Take up a node, all samples on the right.
    pub(crate) fn load(&mut self, samples: &Samples, view: &View) {
        if samples.slopes.is_some() {
            self.values.clear();
            for &i in view.list(samples.p) {
                let target = samples.targets[i as usize];
                if self.values.last() != Some(&target) {
                    self.values.push(target);
                }
                self.target_of[i as usize] = self.values.len() as u32 - 1;
            }
        }
        self.rewind(samples, view);
    }

    /// All samples on the right again.
    pub(crate) fn rewind(&mut self, samples: &Samples, view: &View) {
        self.sums = [Sums::default(), view.sums(samples)];
        self.counts = [0, view.len];
        for &i in view.list(samples.p) {
            self.of_sample[i as usize] = 1;
        }
        if samples.slopes.is_some() {
            for side in &mut self.targets {
                side.clear(self.values.len());
            }
            for &i in view.list(samples.p) {
                self.targets[1].add(self.target_of[i as usize], samples.sums[i as usize].weight);
            }
        }
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
        if samples.slopes.is_some() {
            let target = self.target_of[i as usize];
            self.targets[to].add(target, own.weight);
            self.targets[1 - to].remove(target, own.weight);
        }
    }
}
