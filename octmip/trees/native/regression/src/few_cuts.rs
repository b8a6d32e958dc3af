//! Bounds of the best cut of a feature from a few of its cuts, before it is scanned: sloped errors, equal weights.
//!
//! A node's samples are parted into runs along each feature. A cut inside a run has all earlier runs left of it and
//! all later ones right of it, and one constant for fewer samples never errs by more. So the feature's best cut errs
//! by no less than the least, over the runs, of what the runs before err by with one constant and those after with
//! another.
//!
//! All runs are counted at once, along the samples of a side in the order of their targets: a gap between two targets
//! costs the lesser of what the samples below and those above cost. Numbers are of 32 bits: whole ones as far as they
//! are counts, and a sum of terms that are 0 or more is too large by a rounding for each term at most, which is taken
//! off.

use pulp::{Simd, WithSimd};

use crate::samples::Samples;
use crate::sides::Sides;
use crate::slopes::Slopes;
use crate::view::View;

/// Runs of a feature.
const N_RUNS: usize = 16;

/// On so few samples a scan is as quick.
const SMALLEST: usize = 32;

/// Largest whole number below which all are numbers of 32 bits.
const MOST: f64 = (1 << 24) as f64;

/// A number for each run.
type Row = [f32; N_RUNS];

/// Which ends of runs a sample of each run lies before.
const BEFORE: [Row; N_RUNS] = {
    let mut rows = [[0.0; N_RUNS]; N_RUNS];
    let mut run = 0;
    while run < N_RUNS {
        let mut end = run;
        while end < N_RUNS {
            rows[run][end] = 1.0;
            end += 1;
        }
        run += 1;
    }
    rows
};

/// The samples of one side of a cut in the order of their targets.
#[derive(Debug, Default)]
struct Side {
    ids: Vec<u32>,
    /// Distance of each target from the next, no larger than it is.
    gaps: Vec<f32>,
}

/// Runs of the features of a node, and the sides of a cut.
#[derive(Debug, Default)]
pub(crate) struct FewCuts {
    arch: pulp::Arch,
    /// Run of each sample along each feature (`p * n`), where they are laid out.
    runs: Vec<u8>,
    is_laid: bool,
    sides: [Side; 2],
    is_taken: [bool; 2],
}

impl FewCuts {
    /// Whether there are bounds of these samples, so many of them on a side.
    pub(crate) fn serve(samples: &Samples, n: usize) -> bool {
        let is_counted = |slopes: Slopes| n as f64 * slopes.most(1.0, 1.0) < MOST;
        n >= SMALLEST && samples.weight.is_some() && samples.slopes.is_some_and(is_counted)
    }

    /// Forget the node.
    pub(crate) fn leave_node(&mut self) {
        self.is_laid = false;
        self.leave_cut();
    }

    /// Forget the sides of the cut.
    pub(crate) fn leave_cut(&mut self) {
        self.is_taken = [false; 2];
    }

    /// No cut of feature `g` errs by less on a side.
    pub(crate) fn bound(&mut self, samples: &Samples, view: &View, sides: &Sides, g: usize, side: usize) -> f64 {
        if !std::mem::replace(&mut self.is_laid, true) {
            self.lay(samples, view);
        }
        if !std::mem::replace(&mut self.is_taken[side], true) {
            self.sides[side].take(samples, view, sides, side);
        }
        let Side { ids, gaps } = &self.sides[side];
        let runs = &self.runs[g * samples.n..(g + 1) * samples.n];
        let slopes = samples.slopes.unwrap_or_default();
        let least = match slopes.are_even() {
            true => self.arch.dispatch(Pass::<true> { slopes, ids, gaps, runs }),
            false => self.arch.dispatch(Pass::<false> { slopes, ids, gaps, runs }),
        };
        let rounding = (ids.len() + 8) as f64 * f64::from(f32::EPSILON);
        samples.weight.unwrap_or(0.0) * f64::from(least) * (1.0 - rounding)
    }

    fn lay(&mut self, samples: &Samples, view: &View) {
        self.runs.resize(samples.p * samples.n, 0);
        for (g, runs) in self.runs.chunks_exact_mut(samples.n).enumerate() {
            for (k, &i) in view.list(g).iter().enumerate() {
                runs[i as usize] = (k * N_RUNS / view.len) as u8;
            }
        }
    }
}

impl Side {
    fn take(&mut self, samples: &Samples, view: &View, sides: &Sides, side: usize) {
        let own = view.list(samples.p).iter().filter(|&&i| sides.of_sample[i as usize] as usize == side);
        self.ids.clear();
        self.ids.extend(own);
        let target = |i: u32| samples.targets[i as usize];
        self.gaps.clear();
        // Neither beyond what is summed without overflow nor among the numbers of fewer digits.
        let gap = |low: u32, high: u32| (target(high) - target(low)).min(1e20) as f32;
        let gaps = self.ids.windows(2).map(|pair| gap(pair[0], pair[1]));
        self.gaps.extend(gaps.map(|gap| if gap > 1e-20 { gap } else { 0.0 }).chain([0.0]));
    }
}

/// A pass over one side.
struct Pass<'a, const EVEN: bool> {
    slopes: Slopes,
    ids: &'a [u32],
    gaps: &'a [f32],
    runs: &'a [u8],
}

impl<const EVEN: bool> WithSimd for Pass<'_, EVEN> {
    type Output = f32;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> f32 {
        let Slopes { up, down } = self.slopes.known::<EVEN>();
        let (up, down) = (up as f32, down as f32);
        let before = |&i: &u32| &BEFORE[self.runs[i as usize] as usize % N_RUNS];
        // The lesser of what counts below and above a gap cost; not NaN: one instruction, where `f32::min` is several.
        let less = |below: f32, above: f32| {
            let (below, above) = (down * below, up * above);
            if below < above { below } else { above }
        };
        let mut left: Row = [0.0; N_RUNS];
        for i in self.ids {
            let row = *before(i);
            for end in 0..N_RUNS {
                left[end] += row[end];
            }
        }
        let n = self.ids.len() as f32;
        let (mut passed, mut below): (f32, Row) = (0.0, [0.0; N_RUNS]);
        let mut errors: [Row; 2] = [[0.0; N_RUNS]; 2];
        for (i, &gap) in self.ids.iter().zip(self.gaps) {
            let row = *before(i);
            passed += 1.0;
            for end in 0..N_RUNS {
                below[end] += row[end];
                let (own, rest) = (below[end], passed - below[end]);
                errors[0][end] += gap * less(own, left[end] - own);
                errors[1][end] += gap * less(rest, n - left[end] - rest);
            }
        }
        let inside = (1..N_RUNS).map(|run| errors[0][run - 1] + errors[1][run]);
        inside.fold(errors[1][0], |least, error| if error < least { error } else { least })
    }
}

#[cfg(test)]
mod tests {
    use super::FewCuts;
    use crate::samples::{Question, Samples};
    use crate::scan::Scanner;
    use crate::sides::Sides;
    use crate::slopes::Slopes;
    use crate::view::View;

    #[test]
    fn no_cut_of_a_feature_errs_by_less_than_the_bound_which_is_near_the_best_one() {
        let (mut n_bounds, mut shares) = (0, 0.0);
        for seed in 0..400 {
            let rng = &mut fastrand::Rng::with_seed(seed);
            let (n, n_values) = (rng.usize(80..300), rng.u32(3..300));
            let ranks: Vec<u32> = (0..2 * n).map(|_| rng.u32(0..n_values)).collect();
            let (up, down) = [(1.0, 1.0), (9.0, 1.0), (1.0, 9.0), (2.0, 3.0)][seed as usize % 4];
            let spread = [1e-9, 1.0, 1e9][seed as usize % 3];
            let target = |i: usize| spread * (f64::from(ranks[n + i] / 2) + 9.0 * rng.f64());
            let targets: Vec<f64> = (0..n).map(target).collect();
            let question = Question {
                n,
                p: 2,
                n_ranks: vec![n_values; 2],
                weights: vec![f64::from(1 + n_values % 3); n],
                squares: vec![0.0; n],
                grain: 0.0,
                slopes: Some(Slopes { up, down }),
                penalty: 0.0,
                depth: 2,
                leaf_size: 1,
                allowed: vec![true; 2],
                ranks,
                targets,
            };
            let samples = Samples::new(&question);
            let view = View::root(&samples);
            let (mut sides, mut few, mut scanner) = (Sides::new(n), FewCuts::default(), Scanner::default());
            sides.rewind(&samples, &view);
            for k in [n / 2, n / 3, n - 40] {
                sides.move_to(&samples, &view, 0, k, |_, _| ());
                few.leave_cut();
                for (g, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    if FewCuts::serve(&samples, sides.counts[side]) {
                        let bound = few.bound(&samples, &view, &sides, g, side);
                        let least = scanner.scan(&samples, &view, g, &mut sides, [true; 2])[side].relaxed;
                        assert!(bound <= least * (1.0 + 1e-12), "seed {seed}: {bound} is above {least}");
                        (n_bounds, shares) = (n_bounds + 1, shares + if least > 0.0 { bound / least } else { 1.0 });
                    }
                }
            }
        }
        assert!(n_bounds > 4000 && shares > 0.8 * f64::from(n_bounds), "{n_bounds}: {shares}");
    }
}
