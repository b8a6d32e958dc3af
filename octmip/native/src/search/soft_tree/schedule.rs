//! The schedule of a soft-tree refinement.

/// How to melt.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Heat {
    /// Gradient steps.
    pub(crate) n_steps: usize,
    /// Sharpness at first; at last it is `LAST_SHARPNESS`.
    pub(crate) first_sharpness: f32,
    /// Which planes may look at all features first; they keep fewer and fewer, the leading ones.
    pub(crate) opening: Opening,
}

/// Which planes choose their features anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Opening {
    /// All of them.
    All,
    /// One node's.
    One(u32),
    /// None.
    None,
}
