//! Parts of a tree that are asked for, as they come from outside.

/// A number that limits nothing.
pub const NO_LIMIT: usize = usize::MAX / 4;

/// A place in a tree and what is said of it.
#[derive(Debug, Clone, Default)]
pub struct Named {
    /// Splits of which one stands here: a column, and the largest rank that goes left; None: any. None said: no entry.
    pub splits: Vec<(u32, Option<u32>)>,
    /// Whether a leaf stands here.
    pub is_leaf: bool,
    /// Rows of both sides, further down.
    pub sides: [Option<usize>; 2],
    /// Splits that are named here and below.
    pub n_splits: usize,
}

/// What is asked for; empty tables ask for nothing.
#[derive(Debug, Clone)]
pub struct Rules {
    /// Given splits, the root first.
    pub given: Vec<Named>,
    /// The old tree, the root first.
    pub old: Vec<Named>,
    /// Most places at which the tree may differ from the old one: one of them has a split that the other has not.
    pub max_changes: usize,
    /// Of each column those that may not be split anywhere below it (`p`).
    pub bans: Vec<Vec<u32>>,
}

impl Rules {
    /// A table of places with the numbers of splits at and below each; a side's row must be further down.
    pub fn table(mut rows: Vec<Named>) -> Result<Vec<Named>, String> {
        for row in (0..rows.len()).rev() {
            let mut n_splits = usize::from(!rows[row].splits.is_empty());
            for side in rows[row].sides.into_iter().flatten() {
                if side <= row || side >= rows.len() {
                    return Err(format!("row {row} has the side {side}, expected a row further down"));
                }
                n_splits += rows[side].n_splits;
            }
            rows[row].n_splits = n_splits;
        }
        Ok(rows)
    }

    /// Of each usable feature the usable ones that are banned below it.
    pub(super) fn bans_of(&self, features: &[u32]) -> Vec<Vec<usize>> {
        let usable = |column: &u32| features.iter().position(|feature| feature == column);
        let below = |&column: &u32| self.bans.get(column as usize).map_or(&[][..], Vec::as_slice);
        features.iter().map(|column| below(column).iter().filter_map(usable).collect()).collect()
    }
}
