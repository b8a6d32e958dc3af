//! Branch and bound over thresholds: provably optimal axis-aligned trees.

pub mod answer;
pub mod axis;
pub mod branch;
pub mod budget;
pub mod depth_two;
pub mod directions;
pub mod effort;
pub mod frontier;
pub mod known;
pub mod label_sets;
pub mod log;
pub mod memory;
pub mod plan;
pub mod proof;
pub mod root;
pub mod samples;
pub mod stumps;
pub mod subtree;
pub mod switches;
pub mod view;
