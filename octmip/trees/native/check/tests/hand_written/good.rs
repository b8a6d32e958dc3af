//! Logs that prove what they claim: each with the arithmetic of its claim.

use octmip_check::question::Question;

use crate::problems::*;
use crate::{axis, run, two_feature};

/// Name, question, log, and the bound that it proves.
type GoodLog = (&'static str, Question, String, f64);

/// Logs of axis-aligned trees, and cases of sensors.
fn good_axis_logs() -> Vec<GoodLog> {
    vec![
        // 0 1 0 1: one cut makes two runs, so one sample goes wrong. The checker counts depth 1 by itself.
        ("depth 1", stripes(4, 1), axis("1", "N 1 1 1 | E | end"), 1.0),
        // 0 1 0 1 0 1 in four runs: one wrong. Of cut 3 either side, 0 1 0 and 1 0 1, costs one with one split; every
        // other cut has one of these sides in one of its own.
        ("depth 2", stripes(6, 2), axis("1", "N 2 1 1 | F 0 3 | E | end"), 1.0),
        // A side of one sample or two costs nothing, and one with all three classes, which has two labels, costs two at
        // least: one for each of two samples, or two for one. That is by sets of labels; a sample with a wrong label
        // costs one at least, so that single mistakes would prove one.
        ("label sets", levels(), axis("2", "N 2 1 2 | E | end"), 2.0),
        // The same claim from more cuts than it takes: 2, 3 and 4.
        ("steps", stripes(6, 2), axis("1", "N 2 1 1 | F 0 2 1 1 | E | end"), 1.0),
        // A claim of less is true, too.
        ("claim of 0", stripes(6, 2), axis("0", "N 2 1 0 | E | end"), 0.0),
        // Ten stripes, eight runs: one wrong. Cut 5 leaves five stripes on either side, which four runs cannot part:
        // there cut 2 leaves 0 1 0 on the right, cut 3 on the left, and these lie in a side of every other cut.
        (
            "depth 3",
            stripes(10, 3),
            axis("1", "N 3 1 1 | K 0 5 | L | N 2 1 1 | F 0 2 1 | E | R | N 2 1 1 | F 0 2 1 | E | E | end"),
            1.0,
        ),
        // The same with a bound of depth 2 of all samples. Seven stripes in two runs: three wrong.
        (
            "depth 3 with a bound of all samples",
            stripes(10, 3),
            axis(
                "1",
                "N 3 1 1 | B | N 2 1 1 | F 0 3 | E \
                 | K 0 5 | L | N 2 1 1 | F 0 2 1 | E | R | N 2 1 1 | F 0 2 1 | E | E | end",
            ),
            1.0,
        ),
        // Missing, 0 0 1 1, and the same with the missing ones last: the second column parts them without an error.
        ("missing values", missing(1), axis("0", "N 1 1 0 | E | end").replace("proof 3", "proof 3 missing"), 0.0),
        // With leaves of three two go wrong in the first column, 1 1 0 | 0 1 1, and one in the second, 0 0 1 | 1 1 1.
        (
            "missing values and leaves of three",
            Question { leaf_size: 3, ..missing(1) },
            axis("1", "N 1 3 1 | E | end").replace("proof 3", "proof 3 missing"),
            1.0,
        ),
        // Leaves of two: the only cut is in the middle, 0 1 | 0 1, and two samples go wrong.
        ("leaves of two", Question { leaf_size: 2, ..stripes(4, 1) }, axis("2", "N 1 2 2 | E | end"), 2.0),
        // The same of leaves of any size, which cost no more; and their sides bound those of other cuts.
        (
            "leaves of two by leaves of any size",
            Question { leaf_size: 2, ..stripes(6, 2) },
            axis("1", "N 2 1 1 | F 0 3 | E | end"),
            1.0,
        ),
        (
            "sides with leaves of any size",
            Question { leaf_size: 2, ..stripes(10, 3) },
            axis("1", &format!("N 3 2 1 | K 0 5 | {} | E | end", halves(1))),
            1.0,
        ),
        // A split costs 1.5, so the best is one leaf with two wrong or a split with one: 2 halves of 4 and 5.
        (
            "a penalty in halves",
            Question { leaf_penalty: 1.5, ..stripes(4, 1) },
            axis("4", "N 1 1 4 | E | end").replace("grid 0 0", "grid 1 0"),
            2.0,
        ),
        // Weights of .3 in eighths are 2: two eighths for the one that goes wrong, though it is .3 in truth.
        (
            "weights rounded down",
            Question { weights: vec![0.3; 4], ..stripes(4, 1) },
            axis("2", "N 1 1 2 | E | end").replace("grid 0 0", "grid 3 0"),
            0.25,
        ),
        // .1 is more than 102/1024. What every label costs besides, .5 times four weights, is .2.
        ("numbers written out", tenths(), written_out(WRITTEN_OUT), 0.5 * 4.0 * 0.1 + 102.0 / 1024.0),
        // Only one of two sensors can be paid for: the second feature has one value, so without the first a leaf pays
        // 2.
        ("a budget", two_sensors(false), axis("1", "S 0 | N 1 1 2 | E | N 1 1 1 | E | end"), 1.0),
        // The first sensor alone is beyond the budget: no tree reads it, and one leaf pays 2.
        (
            "a sensor beyond the budget",
            Question { sensor_cost: vec![9.0, 1.0], ..two_sensors(false) },
            axis("2", "N 1 1 2 | E | end"),
            2.0,
        ),
        (
            "a sensor of a line beyond the budget",
            Question { sensor_cost: vec![9.0, 1.0], ..two_sensors(true) },
            two_feature("2", "D | end"),
            2.0,
        ),
    ]
}

/// Logs of two-feature trees.
fn good_two_feature_logs() -> Vec<GoodLog> {
    vec![
        // Four corners, 0 and 1 across: one line leaves one wrong. The checker counts depth 1 by itself.
        ("one line", corners(1), two_feature("1", "D | end"), 1.0),
        ("one line under a budget", two_sensors(true), two_feature("1", "S 0 | D | D | end"), 1.0),
        // Six stripes on an axis, at 0, 1/8 .. 5/8 in coordinates. Right of a cut below 5/16 lies 1 0 1, left of one
        // above it 0 1 0, and either costs one with one split.
        (
            "nodes closed by settled samples",
            runs(1),
            two_feature("1", &format!("C 0 1 | {CUT} | N 0 1 | N 1 0 | end")),
            1.0,
        ),
        // Between 3/16 and 5/16 one sample is open: 0 1 0 and 0 1 0 1 cost one each, less the one that is counted
        // twice.
        (
            "a node closed by settled and open samples",
            runs(1),
            two_feature("1", &format!("C 0 1 | {CUT} | R .1875 .1875 | N 0 1 | W 1 1 | N 1 0 | end")),
            1.0,
        ),
        // The same sample sent right (0): the left child 0 1 costs nothing; or left (1): 0 1 0 costs one.
        (
            "a node closed by its dichotomies",
            runs(1),
            two_feature("1", &format!("C 0 1 | {CUT} | R .1875 .1875 | N 0 1 | E 0:0 1:1 | N 1 0 | end")),
            1.0,
        ),
        // A child's cost is said first, and then taken from it.
        (
            "children that are known",
            runs(1),
            two_feature("1", &format!("C 0 1 | {CUT} | r 1 1 | N 0 1 | l 1 1 | N 1 0 | end")),
            1.0,
        ),
        // Leaves of four out of six samples: no split has two, and one leaf pays three.
        ("too few for two leaves", runs(4), two_feature("3", &format!("C 0 1 | {CUT} | F | F | end")), 3.0),
        // The corners again, one feature of a split costs 1. A leaf pays 2. A root over two features costs 2 by itself;
        // one over one feature leaves 0 and 1 on both sides, and each pays 1, with a split or without.
        (
            "a penalty for each feature",
            Question { leaf_penalty: 1.0, ..corners(2) },
            two_feature("2", "C 0 1 | N 0 0 | C 0 2 | E 10:1 | C 1 0 | T 0 | N 0 0 | N 0 0 | C 1 2 | E 10:1 | end"),
            2.0,
        ),
        // Leaves of three out of four: every dichotomy of the corners leaves one side too small.
        (
            "no dichotomy has two leaves",
            Question { leaf_size: 3, ..corners(2) },
            two_feature("2", "C 0 1 | E | C 0 2 | E | C 1 0 | E | C 1 2 | E | end"),
            2.0,
        ),
    ]
}

#[test]
fn good_logs_are_accepted_for_what_they_prove() {
    for (name, question, log, bound) in good_axis_logs().into_iter().chain(good_two_feature_logs()) {
        let report = run(&question, &log).unwrap_or_else(|refusal| panic!("{name}: {refusal:?}"));
        assert_eq!(report.bound, bound, "{name}");
        assert_eq!(report.n_lines, log.lines().count(), "{name}");
    }
}
