//! The checker of octmip's proof logs: a log is accepted if it proves that no tree of a problem costs less than it
//! claims.
//!
//! It holds no solver and depends on no other crate. A log is checked against a [`question::Question`]: the problem as
//! it was given, in float64. Formats and proofs: docs/theory/proof.md and, for splits over two features,
//! docs/theory/two-feature.md.
//!
//! | module | holds |
//! |---|---|
//! | `input` | the problem, read from its file, and the digests that bind a log to it |
//! | `log` | lines of a log and its header: whole numbers, none above the true cost |
//! | `numbers` | exact arithmetic |
//! | `problem`, `ranked` | the problem in ranks and whole numbers, as checkers and solvers hold it |
//! | `threads` | independent parts of a proof, checked on several threads |
//! | `axis` | the checker of logs of axis-aligned trees |
//! | `regression` | the checker of logs of regression trees |
//! | `two_feature` | the checker of logs of two-feature trees |
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod axis;
mod input;
mod log;
mod numbers;
pub mod problem;
mod ranked;
mod refusal;
pub mod regression;
mod threads;
pub mod two_feature;

pub use input::question;
pub use refusal::Refusal;

use input::question::Question;
use log::cursor::Cursor;
use log::header;

/// The proof of a log that was accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// No tree of the problem costs less.
    pub bound: f64,
    /// Lines of the log.
    pub n_lines: usize,
    /// The line of the claim, from 1.
    pub claim_line: usize,
}

/// Check a log of a problem (as [`Question::validated`] returns it), on so many threads.
pub fn check(question: &Question, log: &str, n_threads: usize) -> Result<Report, Refusal> {
    let lines: Vec<&str> = log.lines().collect();
    let mut cursor = Cursor::new(&lines);
    let header = header::read(question, &mut cursor)?;
    let problem = ranked::problem_of(question, &header.costs);
    if question.is_hyperplane {
        two_feature::check(&problem, cursor, header.claim, n_threads)?;
    } else {
        axis::check(&problem, cursor, header.claim, n_threads)?;
    }
    Ok(Report { bound: header.costs.value(header.claim), n_lines: lines.len(), claim_line: header.line })
}
