//! The samples of a node in the order of a feature.

use octmip_check::problem::Problem;

/// Every feature's samples by rank, made once.
#[derive(Debug)]
pub(crate) struct Orders {
    n: usize,
    sorted: Vec<u32>,
}

impl Orders {
    /// Sort every feature by counting, O(n p).
    pub(crate) fn new(problem: &Problem) -> Self {
        let mut sorted = vec![0; problem.n * problem.p];
        for (f, row) in sorted.chunks_mut(problem.n).enumerate() {
            let ranks = problem.feature(f);
            let mut next = vec![0_u32; problem.n_ranks[f] as usize + 1];
            ranks.iter().for_each(|&r| next[r as usize + 1] += 1);
            for r in 1..next.len() {
                next[r] += next[r - 1];
            }
            for (i, &r) in ranks.iter().enumerate() {
                row[next[r as usize] as usize] = i as u32;
                next[r as usize] += 1;
            }
        }
        Self { n: problem.n, sorted }
    }

    /// All samples in the order of feature `f`.
    pub(crate) fn of(&self, f: u32) -> &[u32] {
        &self.sorted[f as usize * self.n..(f as usize + 1) * self.n]
    }
}

/// Positions of a node's samples in the order of one feature after the other.
///
/// A node with most samples filters the order of all; a small one sorts its own: O(min(n, m log m)) per feature.
#[derive(Debug, Default)]
pub(crate) struct NodeOrder {
    position: Vec<u32>,
    keys: Vec<u64>,
    /// Positions in the node's sample list.
    pub(crate) order: Vec<u32>,
}

const ABSENT: u32 = u32::MAX;

/// Whether so many samples of `n` are sorted by themselves.
fn sorts_its_own(n: usize, samples: &[u32]) -> bool {
    samples.len() * 8 <= n
}

impl NodeOrder {
    /// Take up the samples of a node.
    pub(crate) fn enter(&mut self, n: usize, samples: &[u32]) {
        if sorts_its_own(n, samples) {
            return;
        }
        self.position.clear();
        self.position.resize(n, ABSENT);
        for (j, &i) in samples.iter().enumerate() {
            self.position[i as usize] = j as u32;
        }
    }

    /// Order the samples by feature `f`.
    pub(crate) fn sort(&mut self, problem: &Problem, orders: &Orders, samples: &[u32], f: u32) {
        self.order.clear();
        if !sorts_its_own(problem.n, samples) {
            let positions = orders.of(f).iter().map(|&i| self.position[i as usize]);
            self.order.extend(positions.filter(|&j| j != ABSENT));
            return;
        }
        let ranks = problem.feature(f as usize);
        self.keys.clear();
        let pairs = samples.iter().enumerate();
        self.keys.extend(pairs.map(|(j, &i)| u64::from(ranks[i as usize]) << 32 | j as u64));
        self.keys.sort_unstable();
        self.order.extend(self.keys.iter().map(|&key| key as u32));
    }
}
