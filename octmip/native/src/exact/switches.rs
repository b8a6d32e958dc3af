//! What the exact search can do without; the optimum is the same without any of them.

crate::switches::switches! {
    /// Fewer samples cost no more.
    monotone,
    /// A sample costs at most its swing.
    swing,
    /// Samples between two cuts cost what more labels than leaves must cost.
    mixed_labels,
    /// The same for a whole node.
    label_count,
    /// Solve one level shallower first.
    shallower_first,
    /// Solve children beyond what their own cut needs.
    slack,
    /// Take features in the order of what they reached.
    feature_order,
    /// Stumps from histograms, not from walks along the lists.
    buckets,
    /// Pass over groups of features that cannot hold the best stump.
    group_skip,
    /// The widest vectors of the machine.
    vectors,
}
