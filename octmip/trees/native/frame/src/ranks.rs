//! Dense ranks of numbers: equal numbers share a rank, ranks are 0, 1, ... in ascending order.
//!
//! ```text
//! values    4.0  0.5  1.5  0.5
//! ranks       2    0    1    0
//! distinct  0.5  1.5  4.0
//! ```

/// Ranks and distinct values of one column; the buffer is kept from column to column.
#[derive(Debug, Default)]
pub struct Ranker {
    keyed: Vec<(u64, u32)>,
}

impl Ranker {
    /// Write the dense ranks of finite `values` into `ranks` (of the same length); the distinct values, ascending.
    pub fn rank(&mut self, values: impl Iterator<Item = f64>, ranks: &mut [u32]) -> Vec<f64> {
        self.keyed.clear();
        self.keyed.extend(values.zip(0..).map(|(value, i)| (key(value), i)));
        self.keyed.sort_unstable_by_key(|&(key, _)| key);
        let mut distinct = Vec::new();
        let mut last = None;
        for &(key, i) in &self.keyed {
            if last != Some(key) {
                distinct.push(value(key));
                last = Some(key);
            }
            ranks[i as usize] = distinct.len() as u32 - 1;
        }
        distinct
    }
}

/// A key that orders as finite numbers do; -0.0 is 0.0.
fn key(value: f64) -> u64 {
    let bits = (value + 0.0).to_bits();
    bits ^ (((bits as i64 >> 63) as u64) | 1 << 63)
}

fn value(key: u64) -> f64 {
    f64::from_bits(key ^ ((!(key as i64 >> 63) as u64) | 1 << 63))
}

/// The ids of samples in the order of their ranks, ties by id; ranks are below `n_ranks`.
pub fn sorted_by_rank(ranks: &[u32], n_ranks: u32) -> Vec<u32> {
    let mut start = vec![0u32; n_ranks as usize + 1];
    for &rank in ranks {
        start[rank as usize + 1] += 1;
    }
    for r in 0..n_ranks as usize {
        start[r + 1] += start[r];
    }
    let mut order = vec![0; ranks.len()];
    for (i, &rank) in ranks.iter().enumerate() {
        let place = &mut start[rank as usize];
        order[*place as usize] = i as u32;
        *place += 1;
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_dense_and_values_come_back() {
        let values = [4.0, -0.0, 1.5, 0.0, -3.25, 1e300, -1e-300, 4.0];
        let mut ranks = [0; 8];
        let distinct = Ranker::default().rank(values.iter().copied(), &mut ranks);
        assert_eq!(distinct, [-3.25, -1e-300, 0.0, 1.5, 4.0, 1e300]);
        for (value, rank) in values.iter().zip(ranks) {
            assert_eq!(*value, distinct[rank as usize]);
        }
    }
}
