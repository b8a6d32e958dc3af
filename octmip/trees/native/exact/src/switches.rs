//! Switches of the exact search; the optimum is the same without any of them.

octmip_frame::switches! {
    /// A set of samples costs no less than a part of it.
    monotone,
    /// A set of samples costs at most the cost range of the new samples more than a part of it.
    cost_range,
    /// Carry the bounds of leaves of any size beside those of a least size.
    free,
    /// Samples between two cuts cost what they do with as many labels as leaves.
    mixed_labels,
    /// Trees of many levels pay for as many splits, and a side of a cut is a leaf or pays for a split.
    price,
    /// Count nodes of few values by value, where splits have a price.
    by_values,
    /// Keep the results of nodes that are met again.
    kept,
    /// Solve one level shallower first.
    shallower_first,
    /// Show the bound that follows from trees of one level fewer.
    level_below,
    /// Solve children beyond what their own cut needs.
    slack,
    /// Take features in the order of their incumbents one level lower.
    feature_order,
    /// StumpSolver from histograms, not from walks along the lists.
    buckets,
    /// Lower the bounds of buckets that may hide a better stump, before they are walked.
    distinct_labels,
    /// Search on equal samples merged.
    merging,
    /// Take from equal samples what they gain under every label.
    cancelling,
    /// The widest vectors of the machine.
    vectors,
}

impl Switches {
    /// Without the prunes that the checker of a log does not know.
    pub(crate) fn of_logs(self) -> Self {
        Self { cancelling: false, price: false, kept: false, ..self }
    }
}
