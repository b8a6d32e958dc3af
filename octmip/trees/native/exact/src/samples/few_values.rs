//! Samples of few values: the cell of each value and label, and what equal samples of different labels lose.

use crate::samples::Samples;
use crate::samples::merging::for_each_group;
use octmip_check::problem::Problem;

impl Samples {
    /// The samples of a group of equal ones go to one leaf, which gains under one label alone. All but the label that
    /// they gain most under is lost, whatever the tree: of the samples of the others, what they would have gained.
    pub(super) fn set_lost(&mut self, problem: &Problem) {
        let usable: Vec<usize> = self.features.iter().map(|&f| f as usize).collect();
        let mut lost = vec![0; self.n];
        for_each_group(problem, &usable, |group| {
            let mut gains = vec![0; self.n_labels];
            group.iter().for_each(|&i| self.count(i, 1, &mut gains));
            let best = (0..self.n_labels).max_by_key(|&label| gains[label]);
            for &i in group.iter().filter(|&&i| Some(self.profile[i as usize] as usize) != best) {
                lost[i as usize] = self.multiplicity[i as usize];
            }
        });
        if lost.iter().any(|&cost| cost > 0) {
            self.lost = lost;
        }
    }

    pub(super) fn set_cells(&mut self) {
        let n_cells = self.n_values * self.n_labels;
        if self.leaf_size > 1 || n_cells > (self.p * self.n).min(1 << 16) {
            return;
        }
        let firsts = self.values.iter().scan(0, |first, &values| Some(std::mem::replace(first, *first + values)));
        let firsts: Vec<usize> = firsts.collect();
        let cell =
            |i: usize, f: usize| (firsts[f] + self.ranks_of(f)[i] as usize) * self.n_labels + self.profile[i] as usize;
        self.cells =
            (0..self.n).flat_map(|i| (0..self.p).map(move |f| (i, f))).map(|(i, f)| cell(i, f) as u16).collect();
    }

    /// The cells of a sample (`p`).
    #[inline(always)]
    pub(crate) fn cells_of(&self, sample: u32) -> &[u16] {
        &self.cells[sample as usize * self.p..][..self.p]
    }
}
