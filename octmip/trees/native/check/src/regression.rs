//! The checker of logs of regression trees: axis-aligned, one number in each leaf, squared or sloped error.
//!
//! Format and proofs: docs/theory/regression.md. Writers of logs use its bounds, so that they write what it needs.

mod bins;
mod clusters;
pub mod cuts;
pub mod grid;
mod header;
mod nodes;
mod problem_file;
mod quantiles;
pub mod question;
pub mod slopes;
pub mod stumps;

use crate::Report;
use crate::log::cursor::Cursor;
use crate::refusal::Refusal;
use nodes::Checker;
use question::RegressionQuestion;

/// Check a log of a problem, as [`RegressionQuestion::validated`] returns it.
pub fn check(question: &RegressionQuestion, log: &str) -> Result<Report, Refusal> {
    let lines: Vec<&str> = log.lines().collect();
    let mut cursor = Cursor::new(&lines);
    let (samples, claim) = header::read(question, &mut cursor)?;
    let claim_line = cursor.line();
    let mut checker = Checker { q: &samples, cursor };
    checker.cases(claim)?;
    checker.cursor.expect_end()?;
    Ok(Report { bound: samples.value(claim), n_lines: lines.len(), claim_line })
}
