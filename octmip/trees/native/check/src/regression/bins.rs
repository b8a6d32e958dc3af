//! Bins of the sorted targets.

/// Most bins.
pub(crate) const N_BINS: usize = 16;

/// Bins of the sorted targets: that of each sample, and the least and greatest target of each.
#[derive(Debug)]
pub(crate) struct Bins {
    pub(crate) of_sample: Vec<u8>,
    pub(crate) ends: Vec<(i64, i64)>,
}

impl Bins {
    /// Bins of about as many samples each, one target never in two.
    pub(crate) fn of(targets: &[i64], by_target: &[u32]) -> Self {
        let (mut of_sample, mut ends) = (vec![0; targets.len()], Vec::<(i64, i64)>::new());
        let mut n_distinct = by_target.chunk_by(|&i, &j| targets[i as usize] == targets[j as usize]).count();
        let mut n_seen = 0;
        for run in by_target.chunk_by(|&i, &j| targets[i as usize] == targets[j as usize]) {
            let target = targets[run[0] as usize];
            let is_full = n_seen * N_BINS >= ends.len() * targets.len();
            if ends.is_empty() || (ends.len() < N_BINS && (is_full || n_distinct <= N_BINS - ends.len())) {
                ends.push((target, target));
            }
            let bin = ends.len() - 1;
            ends[bin].1 = target;
            run.iter().for_each(|&i| of_sample[i as usize] = bin as u8);
            n_seen += run.len();
            n_distinct -= 1;
        }
        Self { of_sample, ends }
    }
}
