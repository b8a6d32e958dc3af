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
pub mod memory;
pub mod plan;
pub mod proof;
pub mod root;
pub mod samples;
pub mod stumps;
pub mod subtree;
pub mod view;
pub mod watch;

/// Which prunes and bounds are used; the optimum is the same without any of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Switches {
    /// Fewer samples cost no more.
    pub monotone: bool,
    /// A sample costs at most its swing.
    pub swing: bool,
    /// Samples between two cuts cost what more labels than leaves must cost.
    pub mixed_labels: bool,
    /// The same for a whole node.
    pub label_count: bool,
    /// Solve one level shallower first.
    pub shallower_first: bool,
    /// Solve children beyond what their own cut needs.
    pub slack: bool,
    /// Take features in the order of what they reached.
    pub feature_order: bool,
    /// Stumps from histograms, not from walks along the lists.
    pub buckets: bool,
    /// Pass over groups of features that cannot hold the best stump.
    pub group_skip: bool,
    /// The widest vectors of the machine.
    pub vectors: bool,
}

impl Default for Switches {
    fn default() -> Self {
        Self {
            monotone: true,
            swing: true,
            mixed_labels: true,
            label_count: true,
            shallower_first: true,
            slack: true,
            feature_order: true,
            buckets: true,
            group_skip: true,
            vectors: true,
        }
    }
}

impl Switches {
    /// The names of the switches.
    pub const NAMES: [&'static str; 10] = [
        "monotone",
        "swing",
        "mixed_labels",
        "label_count",
        "shallower_first",
        "slack",
        "feature_order",
        "buckets",
        "group_skip",
        "vectors",
    ];

    /// The switch of a name.
    pub fn by_name(&mut self, name: &str) -> Option<&mut bool> {
        Some(match name {
            "monotone" => &mut self.monotone,
            "swing" => &mut self.swing,
            "mixed_labels" => &mut self.mixed_labels,
            "label_count" => &mut self.label_count,
            "shallower_first" => &mut self.shallower_first,
            "slack" => &mut self.slack,
            "feature_order" => &mut self.feature_order,
            "buckets" => &mut self.buckets,
            "group_skip" => &mut self.group_skip,
            "vectors" => &mut self.vectors,
            _ => return None,
        })
    }
}
