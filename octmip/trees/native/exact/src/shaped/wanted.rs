//! The shape that is wanted, and what a search knows of it so far.

use std::sync::atomic::{AtomicI64, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::shaped::rules::Rules;
use octmip_frame::control::Limits;
use octmip_frame::tree::Tree;

/// The shape that is wanted beside depth and leaf size, and when to stop.
#[derive(Debug, Clone)]
pub struct Options {
    /// When to stop early.
    pub limits: Limits,
    /// A tree of the shape and its objective.
    pub incumbent: Option<(i64, Tree)>,
    /// The best tree without directions and its objective.
    pub free: Option<(i64, Tree)>,
    /// Most splits in the tree.
    pub max_splits: usize,
    /// Of each feature: 1 where the predicted class never falls as it rises, -1 where it never rises, 0 where it may do
    /// either (`p`).
    pub directions: Vec<i8>,
    /// Parts of the tree that are asked for; not together with directions.
    pub rules: Option<Rules>,
}

/// What is known so far, in units of the samples and above the base.
#[derive(Debug)]
pub(super) struct Known {
    pub best: Mutex<(i64, Option<Tree>)>,
    pub bound: AtomicI64,
}

impl Known {
    /// A tree to start from, and no bound.
    pub(super) fn new(start: (i64, Option<Tree>)) -> Self {
        Self { best: Mutex::new(start), bound: AtomicI64::new(0) }
    }

    /// What no tree costs less than.
    pub(super) fn bound(&self) -> i64 {
        self.bound.load(Ordering::Relaxed)
    }

    /// Cost of the best tree, and the tree itself; None where it is the leaf.
    pub(super) fn best(&self) -> (i64, Option<Tree>) {
        self.best.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Take up a tree if it costs less.
    pub(super) fn see(&self, cost: i64, tree: impl FnOnce() -> Tree) {
        let mut best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
        if cost < best.0 {
            *best = (cost, Some(tree()));
        }
    }

    /// Take up a bound.
    pub(super) fn raise(&self, bound: i64) {
        self.bound.fetch_max(bound, Ordering::Relaxed);
    }
}
