//! Which leaf each row of a table reaches: many rows at a time, level by level.

/// A tree of cuts by thresholds as flat lists; a leaf leads to itself.
pub struct ThresholdTree {
    /// Feature of each split.
    pub feature: Vec<u32>,
    /// Largest value that goes left; NaN where every reading that there is goes right.
    pub threshold: Vec<f64>,
    /// Left and right child.
    pub children: Vec<[u32; 2]>,
    /// Whether a missing reading goes right; none where the split has no side for it.
    pub missing: Vec<Option<bool>>,
    /// Levels of splits.
    pub depth: usize,
}

/// Rows that go down together: while one waits for its reading, the others are asked for theirs.
const BLOCK: usize = 16;

impl ThresholdTree {
    /// Whether all lists have an entry for each node, and features and children that there are, `p` features in a row.
    pub fn is_sound(&self, p: usize) -> bool {
        let n = self.feature.len();
        let is_whole = self.threshold.len() == n && self.children.len() == n && self.missing.len() == n;
        let is_inside = |children: &[u32; 2]| children.iter().all(|&child| (child as usize) < n);
        n > 0 && is_whole && self.children.iter().all(is_inside) && self.feature.iter().all(|&f| (f as usize) < p)
    }

    /// The node that each row (`n * p`, row after row) ends at after `depth` steps; None where a reading is missing and
    /// its split has no side for it.
    pub fn reached<T: Copy + Into<f64>>(&self, rows: &[T], p: usize) -> Option<Vec<u32>> {
        let mut ends = vec![0u32; rows.len() / p];
        for (rows, at) in rows.chunks(BLOCK * p).zip(ends.chunks_mut(BLOCK)) {
            for _ in 0..self.depth {
                for (row, node) in rows.chunks_exact(p).zip(&mut *at) {
                    let k = *node as usize;
                    let value: f64 = row[self.feature[k] as usize].into();
                    let is_left = value <= self.threshold[k];
                    let is_right = if value.is_nan() { self.missing[k]? } else { !is_left };
                    *node = self.children[k][usize::from(is_right)];
                }
            }
        }
        Some(ends)
    }
}

#[cfg(test)]
mod tests {
    use super::ThresholdTree;

    fn tree(missing: Option<bool>) -> ThresholdTree {
        let leaf = Some(false);
        ThresholdTree {
            feature: vec![1, 0, 0, 0, 0],
            threshold: vec![0.5, -1.0, f64::NAN, f64::NAN, f64::NAN],
            children: vec![[1, 2], [3, 4], [2, 2], [3, 3], [4, 4]],
            missing: vec![missing, Some(true), leaf, leaf, leaf],
            depth: 2,
        }
    }

    #[test]
    fn rows_go_down_to_their_leaves() {
        let rows = [-1.0, 0.5, -0.9, 0.0, 0.0, 0.6, f64::NAN, 0.0, 0.0, f64::NAN];
        assert_eq!(tree(Some(true)).reached(&rows, 2), Some(vec![3, 4, 2, 4, 2]));
        assert_eq!(tree(None).reached(&rows[..8], 2), Some(vec![3, 4, 2, 4]));
        assert_eq!(tree(None).reached(&rows, 2), None);
    }

    #[test]
    fn a_threshold_between_two_numbers_of_32_bits_is_not_rounded() {
        let (low, high) = (1.0f32, 1.0f32.next_up());
        let mut tree = tree(None);
        tree.threshold[0] = (f64::from(low) + f64::from(high)) / 2.0;
        assert_eq!(tree.reached(&[-2.0, low, -2.0, high], 2), Some(vec![3, 2]));
    }

    #[test]
    fn children_and_features_that_are_not_there_are_found() {
        assert!(tree(None).is_sound(2));
        assert!(!tree(None).is_sound(1));
        let mut other = tree(None);
        other.children[0] = [1, 5];
        assert!(!other.is_sound(2));
    }
}
