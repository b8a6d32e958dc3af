//! The header of a log: which problem it is of, the whole numbers that it counts in, and what it claims.

use crate::input::question::Question;
use crate::log::cursor::{Cursor, whole_number};
use crate::log::whole_costs::{CAPACITY, WholeCosts, rounded, written_out};
use crate::refusal::{Checked, ensure, shown};

const FORMAT: &str = "octmip-proof 3";
/// Least and largest exponent of a unit: the least product of two float64 is 2^-2148.
const EXPONENT: (i64, i64) = (-2200, 2200);
/// Least and largest weight, cost, penalty or claim.
const WHOLE: (i64, i64) = (0, CAPACITY - 1);
/// Trees over more than one feature per split have logs up to this depth, and up to so many features per split.
const MOST_DEPTH: usize = 2;
const MOST_FEATURES: usize = 2;

/// The header of a log.
pub(crate) struct Header {
    pub(crate) costs: WholeCosts,
    /// Every tree costs that much or more, in whole numbers.
    pub(crate) claim: i64,
    /// The line of the claim, which is the last one of the header.
    pub(crate) line: usize,
}

/// Read a header; refuse one of another problem, and whole numbers above the true costs.
pub(crate) fn read(question: &Question, cursor: &mut Cursor<'_>) -> Checked<Header> {
    check_identity(question, cursor)?;
    let costs = if cursor.peek().is_some_and(|line| line.starts_with("unit ")) {
        read_written_out(question, cursor)?
    } else {
        read_rounded(question, cursor)?
    };
    let claim = numbers(cursor, "claim", WHOLE, Some(1), "one whole number below 2^61")?[0];
    Ok(Header { costs, claim, line: cursor.line() })
}

fn check_identity(question: &Question, cursor: &mut Cursor<'_>) -> Checked<()> {
    let kind = if question.is_hyperplane { " two-feature" } else { "" };
    let first = &format!("{FORMAT}{kind}{}", if question.has_missing() { " missing" } else { "" });
    let got = cursor.read().unwrap_or("");
    let is_older = ["octmip-proof 1", "octmip-proof 2"].iter().any(|old| got.starts_with(old));
    ensure!(!is_older, 1, "{} was written by an older octmip; write the log again", shown(got));
    ensure!(got == first, 1, "got {}, expected {first:?}", shown(got));
    let is_covered = !question.is_hyperplane || (question.depth <= MOST_DEPTH && question.split_size <= MOST_FEATURES);
    let (depth, size) = (question.depth, question.split_size);
    ensure!(is_covered, 1, "trees of depth {depth} with {size} features per split have no proof logs");
    let fields = [
        ("data", question.data_digest(), "the samples, labels and weights"),
        ("question", question.question_digest(), "depth, costs, limits and sensors"),
    ];
    for (name, digest, meaning) in fields {
        let (got, expected) = (cursor.read().unwrap_or(""), format!("{name} {digest}"));
        let line = cursor.line();
        ensure!(got == expected, line, "got {}, expected {expected:?} of {meaning} of the problem", shown(got));
    }
    Ok(())
}

/// Weights, costs and penalty times powers of two, rounded down.
fn read_rounded(question: &Question, cursor: &mut Cursor<'_>) -> Checked<WholeCosts> {
    let expected = "two exponents within 2200 (or \"unit\" and the numbers written out)";
    let exponents = numbers(cursor, "grid", EXPONENT, Some(2), expected)?;
    rounded(question, exponents[0], exponents[1], cursor.line())
}

/// Whole numbers as they stand in the log, each compared with the true one.
fn read_written_out(question: &Question, cursor: &mut Cursor<'_>) -> Checked<WholeCosts> {
    let exponent = numbers(cursor, "unit", EXPONENT, Some(1), "one exponent within 2200")?[0];
    let mut list = |name| numbers(cursor, name, WHOLE, None, "whole numbers below 2^61");
    let (costs, rows, weights) = (list("costs")?, list("rows")?, list("weights")?);
    let penalty = numbers(cursor, "penalty", WHOLE, Some(1), "one whole number below 2^61")?[0];
    written_out(question, exponent, [costs, rows, weights], penalty, cursor.line())
}

/// The numbers of the next line, which must have this name: so many (None: one or more), all from `least` to `most`.
pub(crate) fn numbers(
    cursor: &mut Cursor<'_>,
    name: &str,
    (least, most): (i64, i64),
    count: Option<usize>,
    expected: &str,
) -> Checked<Vec<i64>> {
    let text = cursor.read().unwrap_or("");
    let (first, rest) = text.split_once(' ').unwrap_or((text, ""));
    let numbers: Option<Vec<i64>> = rest.split(' ').map(signed).collect();
    let fits = |numbers: &Vec<i64>| {
        let is_count_right = count.is_none_or(|count| numbers.len() == count);
        first == name && is_count_right && numbers.iter().all(|number| (least..=most).contains(number))
    };
    let numbers = numbers.filter(fits);
    ensure!(numbers.is_some(), cursor.line(), "got {}, expected {name:?} and {expected}", shown(text));
    Ok(numbers.unwrap_or_default())
}

fn signed(word: &str) -> Option<i64> {
    match word.strip_prefix('-') {
        Some(digits) => whole_number(digits).map(|number| -number),
        None => whole_number(word),
    }
}
