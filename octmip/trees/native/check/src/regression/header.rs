//! The header of a log of regression trees: loss, problem, grid and claim.

use crate::log::cursor::Cursor;
use crate::log::header::numbers;
use crate::refusal::{Checked, Refusal, ensure, shown};
use crate::regression::grid::{Samples, Scale};
use crate::regression::question::RegressionQuestion;
use crate::regression::slopes::Slopes;

/// Least and largest exponent of weights, targets and costs.
const EXPONENT: (i64, i64) = (-2200, 2200);
const MOST_CLAIM: i64 = (1 << 61) - 1;

/// Read a header; refuse one of another problem. Returns the samples on the log's grid and the claim.
pub(super) fn read(question: &RegressionQuestion, cursor: &mut Cursor<'_>) -> Checked<(Samples, i64)> {
    let loss = Slopes::named(question.slopes);
    let fields = [
        (format!("octmip-proof 3 regression {loss}"), "a log of these trees and this loss"),
        (format!("data {}", question.data_digest()), "samples, targets and weights of the problem"),
        (format!("question {}", question.question_digest()), "loss, depth, limits and sensors of the problem"),
    ];
    for (expected, meaning) in fields {
        let got = cursor.read().unwrap_or("");
        ensure!(got == expected, cursor.line(), "got {}, expected {expected:?}: {meaning}", shown(got));
    }
    let exponents = numbers(cursor, "grid", EXPONENT, Some(4), "four exponents within 2200, the third 0 to 100")?;
    let line = cursor.line();
    ensure!((0..=100).contains(&exponents[2]), line, "the exponent of costs is {}, expected 0 to 100", exponents[2]);
    let scale = Scale { weight: exponents[0], target: exponents[1], cost: exponents[2] as u32, reach: exponents[3] };
    let samples = Samples::on_grid(question, scale).map_err(|reason| Refusal { line, reason })?;
    let claim = numbers(cursor, "claim", (0, MOST_CLAIM), Some(1), "one whole number below 2^61")?[0];
    Ok((samples, claim))
}
