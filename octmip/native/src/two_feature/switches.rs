//! What the two-feature search can do without; the optimum is the same without any of them.

crate::switches::switches! {
    /// A box costs what its settled samples cost.
    narrow,
    /// A box costs what settled and open samples cost together, less the most that the open ones can cost.
    wide,
    /// Samples of a class that no leaf names are wrong wherever they go.
    labels_due,
    /// A child costs what its samples cost when each may choose one of two labels.
    two_labels,
    /// Strips that cannot hold a child's split are struck off for all boxes inside.
    dead_strips,
    /// What is known of a set of samples is held against sets that differ in few.
    known_sets,
    /// Splits that were best in other boxes are tried first.
    known_lines,
    /// The bound of settled and open samples together is left out while it closes few boxes.
    spared,
    /// Neighbouring strips are bounded as one first.
    grouped,
    /// A bound is left unfinished once it cannot reach its target.
    hopeless,
    /// A bound is not begun where the best known splits say that it cannot reach its target.
    reach,
    /// Boxes are bounded up to a target below the incumbent first.
    targets,
    /// Ways of parting that leave no room in a cell are passed over.
    room,
}
