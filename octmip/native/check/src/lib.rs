//! An independent checker of octmip's proof logs: does a log prove that no tree of a problem costs less than it claims?
//!
//! It holds no solver and depends on no other crate. A log is checked against a [`question::Question`]: the problem as
//! it was given, in float64. Formats and proofs: docs/theory/proof.md and, for splits over two features,
//! docs/theory/two-feature.md.
//!
//! | module | holds |
//! |---|---|
//! | `question`, `json`, `sha256` | the problem, read from its file, and the digests that bind a log to it |
//! | `header`, `whole_costs`, `exact_numbers` | the header of a log: whole numbers, none above the true cost |
//! | `problem`, `ranked` | the problem in ranks and whole numbers, as checkers and solvers hold it |
//! | `axis` | the checker of logs of axis-aligned trees |
//! | `lines` | the checker of logs of two-feature trees |
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod axis;
mod cursor;
pub mod exact_numbers;
mod header;
pub mod json;
pub mod lines;
pub mod problem;
pub mod question;
mod ranked;
mod refusal;
mod sensors;
pub mod sha256;
mod whole_costs;

pub use refusal::Refusal;

use cursor::Cursor;
use question::Question;

/// What a log proves that was accepted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Report {
    /// No tree of the problem costs less.
    pub bound: f64,
    /// Lines of the log.
    pub n_lines: usize,
    /// The line of the claim, from 1.
    pub claim_line: usize,
}

/// Check a log of a problem (as [`Question::validated`] returns it), one of two-feature trees on so many threads.
pub fn check(question: &Question, log: &str, n_threads: usize) -> Result<Report, Refusal> {
    let lines: Vec<&str> = log.lines().collect();
    let mut cursor = Cursor::new(&lines);
    let header = header::read(question, &mut cursor)?;
    let problem = ranked::problem_of(question, &header.costs);
    if question.is_hyperplane {
        lines::check(&problem, cursor, header.claim, n_threads)?;
    } else {
        axis::check(&problem, cursor, header.claim)?;
    }
    Ok(Report { bound: header.costs.value(header.claim), n_lines: lines.len(), claim_line: header.line })
}
