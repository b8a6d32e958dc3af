//! Logs written by hand, for problems of a few samples: good ones are accepted, each bad one is refused in its own line
//! and for its own reason, and no reason that the checker knows goes without a log.
//!
//! `DATA` and `QUESTION` stand for the digests, which cannot be written by hand.

mod bad;
mod good;
mod problems;
mod regression;

use octmip_check::question::Question;
use octmip_check::{Refusal, Report, check};

fn run(question: &Question, log: &str) -> Result<Report, Refusal> {
    let log = log.replace("QUESTION", &question.question_digest()).replace("DATA", &question.data_digest());
    check(question, &log, 2)
}

/// A header of format 3, its numbers rounded at 2^0, and a body of lines between bars.
fn axis(claim: &str, body: &str) -> String {
    format!("octmip-proof 3\ndata DATA\nquestion QUESTION\ngrid 0 0\nclaim {claim}\n{}", lines(body))
}

fn two_feature(claim: &str, body: &str) -> String {
    axis(claim, body).replacen("proof 3", "proof 3 two-feature", 1)
}

fn lines(body: &str) -> String {
    body.split('|').map(|line| format!("{}\n", line.trim())).collect()
}
