//! The schedule of a soft-tree refinement.

/// The gradient steps of a soft-tree refinement.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    /// Gradient steps.
    pub(crate) n_steps: usize,
    /// Inverse temperature at first; at last it is `LAST_INVERSE_TEMPERATURE`.
    pub(crate) first_inverse_temperature: f32,
    /// The planes that look at all features first; they keep fewer and fewer, the leading ones.
    pub(crate) reselection: Reselection,
}

/// The planes that choose their features again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Reselection {
    /// All of them.
    All,
    /// That of one node.
    One(u32),
    /// None.
    None,
}
