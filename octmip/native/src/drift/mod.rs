//! Trees of least worst case while gauges are off: some of them, each by an amount within its band.
//!
//! ```text
//! instance    samples with the lowest, the true and the highest rank of every reading
//! shares      scenarios (which nodes are off), mixed to one additive bound
//! label_sets  the labels that both children may predict, and what every move of a sample costs
//! zones       the samples at a cut of the root: surely left, in its band, surely right
//! scan        the least mixed cost of a child, over all its cuts
//! candidates  children that may belong to a better tree, and what they cost in every scenario
//! pairs       two children joined: the worst case itself
//! cut         one cut of the root: its bound, then its trees
//! reach       cuts near a solved one that it closes too
//! run         the cuts of the root, the least bound first
//! draft       any tree, measured and changed
//! step        the best cut of one node while the others stay
//! search      local search over whole trees
//! ```
//!
//! The proof is in docs/theory/drift.md.

mod candidates;
mod cut;
mod draft;
mod instance;
mod label_sets;
mod pairs;
mod reach;
mod run;
mod scan;
mod search;
mod shares;
mod step;
mod zones;

pub use instance::Bands;
pub use run::solve;
pub use search::search;
