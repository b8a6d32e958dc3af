//! Trees of least worst case while gauges are off: some of them, each by an amount within its band.
//!
//! ```text
//! instance    samples with the lowest, the true and the highest rank of every reading
//! draft       any tree, measured and changed
//! shares      scenarios (which nodes are off), mixed to one additive bound
//! label_sets  the labels that both children may predict, and what every move of a sample costs
//! zones       the samples at a cut of the root: surely left, in its band, surely right
//! scan        the least mixed cost of a child, over all its cuts
//! cut         one cut of the root: its bound from mixtures
//! reach       cuts near a solved one that it closes too
//! boxes       trees whose cuts lie in intervals, and a bound by samples
//! table       sums by class over the samples at an interval of cuts of the root
//! bounds      pairs of children at such an interval, bounded by these sums
//! branch_and_bound  intervals of cuts of the root and boxes of trees, the least bound first
//! step        the best cut of one node while the others stay
//! search      local search over whole trees
//! ```
//!
//! The proof is in docs/theory/worst-case.md.

mod bounds;
mod boxes;
mod branch_and_bound;
mod cut;
mod draft;
mod instance;
mod label_sets;
mod reach;
mod scan;
mod search;
mod shares;
mod step;
mod table;
mod zones;

pub use branch_and_bound::solve;
pub use instance::Bands;
pub use search::search;
