//! Logs of regression trees: good ones with the arithmetic of their claims, bad ones with the line that is refused.

use octmip_check::regression::check;
use octmip_check::regression::question::RegressionQuestion;
use octmip_check::regression::slopes::Slopes;
use octmip_check::{Refusal, Report};

/// Targets in the order of one feature.
fn row(targets: &[f64], is_absolute: bool, depth: usize) -> RegressionQuestion {
    RegressionQuestion {
        n: targets.len(),
        p: 1,
        features: (0..targets.len()).map(|i| i as f64).collect(),
        targets: targets.to_vec(),
        weights: vec![1.0; targets.len()],
        slopes: is_absolute.then_some(Slopes::ABSOLUTE),
        depth,
        leaf_size: 1,
        leaf_penalty: 0.0,
        sensor_of_feature: vec![0],
        sensor_cost: vec![1.0],
        sensor_limit: f64::INFINITY,
    }
}

/// 0 9 0 9: one split leaves 9 of absolute error, and 54 of squared error: 0 | 9 0 9 has 162 - 18 * 18 / 3.
fn four(is_absolute: bool) -> RegressionQuestion {
    row(&[0.0, 9.0, 0.0, 9.0], is_absolute, 1)
}

/// 0 9 0 9 0 9 by two levels: four runs, so one target is missed by 9.
fn six() -> RegressionQuestion {
    row(&[0.0, 9.0, 0.0, 9.0, 0.0, 9.0], true, 2)
}

fn ten() -> RegressionQuestion {
    row(&[0.0, 9.0, 0.0, 9.0, 0.0, 9.0, 0.0, 9.0, 0.0, 9.0], true, 3)
}

fn log(question: &RegressionQuestion, grid: &str, claim: i64, body: &str) -> String {
    let loss = Slopes::named(question.slopes);
    let lines: String = body.split('|').map(|line| format!("{}\n", line.trim())).collect();
    format!("octmip-proof 3 regression {loss}\ndata DATA\nquestion QUESTION\ngrid {grid} 1100\nclaim {claim}\n{lines}")
}

fn run(question: &RegressionQuestion, log: &str) -> Result<Report, Refusal> {
    check(question, &log.replace("QUESTION", &question.question_digest()).replace("DATA", &question.data_digest()))
}

const DEEP: &str = "N 3 1 9 | K 0 5 | L | N 2 1 9 | F 0 2 1 | E | R | N 2 1 9 | F 0 2 1 | E | E | end";

#[test]
fn each_good_log_proves_its_bound() {
    let priced = RegressionQuestion { leaf_penalty: 2.5, ..four(true) };
    let broad = RegressionQuestion { leaf_size: 2, ..four(true) };
    let light = RegressionQuestion { weights: vec![0.5, 0.5, 0.0, 0.5], ..four(true) };
    let poor = RegressionQuestion { sensor_limit: 0.5, ..four(true) };
    let high = RegressionQuestion { slopes: Some(Slopes { up: 3, down: 1, over: 4 }), ..four(true) };
    let high_priced = RegressionQuestion { leaf_penalty: 0.75, ..high.clone() };
    let tenths = RegressionQuestion { slopes: Some(Slopes { up: 9, down: 1, over: 10 }), ..four(true) };
    let thirds = row(&[0.0, 1.0 / 3.0, 0.0, 1.0 / 3.0], true, 1);
    let logs = [
        ("absolute", four(true), "0 0 0", 9, "N 1 1 9 | E | end", 9.0),
        ("squared", four(false), "0 0 0", 53, "N 1 1 53 | E | end", 53.0),
        // What a cut explains is rounded up, by one unit of 2^-20 here.
        ("squared, a finer grid", four(false), "0 10 0", 56623103, "N 1 1 56623103 | E | end", 54.0 - 2f64.powi(-20)),
        // A split costs 2.5, on the grid of halves 5.
        ("a penalty", priced, "1 0 0", 23, "N 1 1 23 | E | end", 11.5),
        // Two leaves of two: 9 on either side, as in one leaf.
        ("leaves of two", broad, "0 0 0", 18, "N 1 2 18 | E | end", 18.0),
        // Without the third: 0 | 9 9 has no error.
        ("weights", light, "1 0 0", 0, "N 1 1 0 | E | end", 0.0),
        ("two levels", six(), "0 0 0", 9, "N 2 1 9 | F 0 3 | E | end", 9.0),
        ("three levels", ten(), "0 0 0", 9, DEEP, 9.0),
        // No sensor can be paid: one leaf.
        ("a budget", poor, "0 0 0", 18, "N 1 1 18 | E | end", 18.0),
        // 0 9 0 | 9 or 0 | 9 0 9: one of both is missed by 9, where it is low by 1/4 of that.
        ("a quantile", high, "0 0 0", 9, "N 1 1 9 | E | end", 2.25),
        ("a quantile with a penalty", high_priced, "0 0 0", 12, "N 1 1 12 | E | end", 3.0),
        ("a quantile of tenths", tenths, "0 0 0", 9, "N 1 1 9 | E | end", 0.9f64.next_down()),
        // On the grid of 2^-2 the third is 1: the targets may have moved by 1 each, and nothing is left.
        ("rounded targets", thirds, "0 2 0", 1, "N 1 1 1 | E | end", 0.0),
    ];
    for (name, question, grid, claim, body, bound) in logs {
        let got = run(&question, &log(&question, grid, claim, body));
        assert_eq!(got.map(|report| report.bound), Ok(bound), "{name}");
    }
}

/// Name, question, log, the line that is refused, and how the reason begins.
type BadLog = (&'static str, RegressionQuestion, String, usize, &'static str);

pub fn bad_logs() -> Vec<BadLog> {
    let stump = |grid: &str, claim: i64| log(&four(true), grid, claim, &format!("N 1 1 {claim} | E | end"));
    let huge = RegressionQuestion { weights: vec![1e300; 4], ..four(true) };
    let deep = |old: &str, new: &str| log(&ten(), "0 0 0", 9, &DEEP.replacen(old, new, 1));
    let quarters = RegressionQuestion { slopes: Some(Slopes { up: 3, down: 1, over: 4 }), ..four(true) };
    let quantile = log(&quarters, "0 0 0", 9, "N 1 1 9 | E | end");
    let tenths = || RegressionQuestion { slopes: Some(Slopes { up: 9, down: 1, over: 10 }), ..four(true) };
    let whole = log(&six(), "0 0 0", 9, "N 2 1 9 | F 0 3 | E | end");
    vec![
        ("another loss", four(false), stump("0 0 0", 9), 1, "got \"octmip-proof 3 regression absolute\", expected"),
        ("another quantile", tenths(), quantile.clone(), 1, "got \"octmip-proof 3 regression quantile:3/4\", expected"),
        ("a quantile's raised claim", quarters.clone(), quantile.replace("9", "10"), 6, "a tree costs 9, not 10"),
        ("other data", four(true), stump("0 0 0", 9).replace("DATA", "0"), 2, "got \"data 0\", expected"),
        ("another question", four(true), stump("0 0 0", 9).replace("QUESTION", "0"), 3, "got \"question 0\", expected"),
        ("two exponents", four(true), stump("0 0", 9), 4, "got \"grid 0 0 1100\", expected \"grid\" and four exp"),
        ("an exponent too large", four(true), stump("0 0 101", 9), 4, "the exponent of costs is 101, expected 0 to"),
        ("no whole costs", four(true), stump("0 0 1", 9), 4, "costs divided by 2^1, expected them below 2^60"),
        ("too fine a grid", four(true), stump("40 40 0", 9), 4, "weights of 4398046511104, targets of 98956046"),
        ("too large weights", huge.clone(), log(&huge, "0 0 0", 1, "end"), 4, "weights on this grid reach 2^53"),
        ("no claim", four(true), stump("0 0 0", 9).replace("claim 9", "claim x"), 5, "got \"claim x\", expected \"cl"),
        ("a claim above the tree", four(true), stump("0 0 0", 10), 6, "a tree costs 9, not 10"),
        ("less than claimed", four(true), stump("0 0 0", 9).replace("N 1 1 9", "N 1 1 8"), 6, "this proves 8, not 9"),
        ("another depth", six(), whole.replace("N 2", "N 1"), 6, "expected depth 2, leaves of 1"),
        ("a cut left out", six(), whole.replace("F 0 3\n", ""), 6, "cut 2 of feature 0 may cost less than 9"),
        ("a cut beyond", six(), whole.replace("F 0 3", "F 0 6"), 7, "feature 0 has no cut 6 here"),
        ("another feature", six(), whole.replace("F 0 3", "F 1 3"), 7, "feature 1 has no cut 3 here"),
        (
            "lowered sides",
            ten(),
            log(&ten(), "0 0 0", 9, &DEEP.replace("N 2 1 9", "N 2 1 4")),
            6,
            "cut 5 of feature 0: 8, not 9",
        ),
        ("an end left out", six(), whole.replace("E\n", ""), 8, "got \"end\", expected E and 0 numbers"),
        ("more after the end", six(), format!("{whole}end\n"), 10, "got \"end\" after the end"),
        ("a raised side", ten(), deep("L | N 2 1 9", "L | N 2 1 10"), 9, "cut "),
        ("a side left out", ten(), deep("R | N 2 1 9 | F 0 2 1 | E |", ""), 6, "cut "),
        ("a sensor that is none", four(true), log(&four(true), "0 0 0", 9, "S 1 | end"), 6, "sensor 1 cannot be"),
    ]
}

/// The reasons of all bad logs.
pub fn reasons() -> Vec<String> {
    bad_logs().iter().map(|(name, question, log, ..)| run(question, log).expect_err(name).reason).collect()
}

#[test]
fn each_bad_log_is_refused_in_its_line_and_for_its_reason() {
    let wrong = bad_logs().into_iter().filter_map(|(name, question, log, line, reason)| {
        let got = run(&question, &log);
        let is_so = got.as_ref().is_err_and(|got| got.line == line && got.reason.starts_with(reason));
        (!is_so).then(|| format!("{name}: {got:?}, expected line {line}: {reason}"))
    });
    assert_eq!(wrong.collect::<Vec<_>>(), Vec::<String>::new());
}
