//! Switches of the two-feature search, for its prunes and bounds; the optimum is the same without any of them.

octmip_frame::switches! {
    /// A node costs what its settled samples cost.
    narrow,
    /// A node costs what settled and open samples cost together, less the most that the open ones can cost.
    wide,
    /// Samples of a class that no leaf names are wrong wherever they go.
    label_count,
    /// A child costs what its samples cost when each may choose one of two labels.
    two_labels,
    /// Slope intervals that cannot hold a child's split are struck off for all nodes inside.
    dead_intervals,
    /// A bound of a set of samples also bounds sets that differ in few.
    known_sets,
    /// What splits of an interval save of a set is no less than what they save of its subsets.
    gains,
    /// Splits that were best in other nodes are tried first.
    known_lines,
    /// The bound of settled and open samples together is left out while it closes few nodes.
    spared,
    /// Neighbouring intervals are bounded as one first.
    grouped,
    /// A bound is left unfinished once it cannot reach its target.
    hopeless,
    /// A bound is not begun where the best known splits say that it cannot reach its target.
    reach,
    /// Nodes are bounded up to a target below the incumbent first.
    targets,
    /// Dichotomies that leave no room in a region are passed over.
    room,
}
