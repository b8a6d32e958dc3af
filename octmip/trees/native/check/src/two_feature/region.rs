//! Regions of a dual plane: sets of lines between two edges.

/// Room for rounding.
pub(super) const EPS: f64 = 1.0 / (1u64 << 46) as f64;

/// Lines between two straight edges over a range of t, each edge given by its ends.
#[derive(Debug, Clone, Copy)]
pub struct Region {
    /// Ends of the range of t.
    pub t: [f64; 2],
    pub(super) low: [f64; 2],
    pub(super) high: [f64; 2],
}

impl Region {
    /// All lines over two features that part the samples at all: no sample's value is beyond 2. On an axis t is 0.
    pub fn whole(is_axis: bool) -> Self {
        let t = if is_axis { [0.0; 2] } else { [-1.0, 1.0] };
        Self { t, low: [-2.25; 2], high: [2.25; 2] }
    }

    /// The lines below and above an edge.
    pub fn split(&self, edge: [f64; 2]) -> [Self; 2] {
        [Self { high: edge, ..*self }, Self { low: edge, ..*self }]
    }

    /// The two halves to both sides of t; what the new ends are rounded by is added outside.
    pub fn cut(&self, t: f64) -> [Self; 2] {
        let part = (t - self.t[0]) / (self.t[1] - self.t[0]);
        let low = self.low[0] + part * (self.low[1] - self.low[0]) - EPS / 4.0;
        let high = self.high[0] + part * (self.high[1] - self.high[0]) + EPS / 4.0;
        let half = |s: usize| {
            let mut half = *self;
            (half.t[1 - s], half.low[1 - s], half.high[1 - s]) = (t, low, high);
            half
        };
        [half(0), half(1)]
    }
}
