//! Logs that prove nothing: each with the line that is refused and the reason.

use octmip_check::question::Question;

use crate::problems::*;
use crate::{axis, run, two_feature};

/// Name, question, log, the line that is refused, and how the reason begins.
type BadLog = (&'static str, Question, String, usize, &'static str);

fn four() -> Question {
    stripes(4, 1)
}

fn six() -> Question {
    stripes(6, 2)
}

fn stump(claim: &str) -> String {
    axis(claim, &format!("N 1 1 {claim} | E | end"))
}

fn bad_logs() -> Vec<BadLog> {
    [bad_headers(), bad_numbers(), bad_axis_bodies(), bad_two_feature_bodies()].into_iter().flatten().collect()
}

/// Headers.
fn bad_headers() -> Vec<BadLog> {
    vec![
        ("nothing", four(), "".into(), 1, "got \"\", expected \"octmip-proof 3\""),
        ("another format", four(), stump("1").replace("proof 3", "proof 4"), 1, "got \"octmip-proof 4\""),
        (
            "an older format",
            four(),
            stump("1").replace("proof 3", "proof 2"),
            1,
            "\"octmip-proof 2\" was written by an",
        ),
        (
            "another sort of split",
            corners(1),
            axis("1", "D | end"),
            1,
            "got \"octmip-proof 3\", expected \"octmip-proof 3 two",
        ),
        (
            "trees without logs",
            corners(3),
            two_feature("0", "end"),
            1,
            "trees of depth 3 with 2 features per split have no",
        ),
        ("other data", stripes(6, 1), stump("1").replace("DATA", &four().data_digest()), 2, "got \"data "),
        ("another question", six(), stump("1").replace("QUESTION", &four().question_digest()), 3, "got \"question "),
        (
            "a grid of one number",
            four(),
            stump("1").replace("grid 0 0", "grid 0"),
            4,
            "got \"grid 0\", expected \"grid\"",
        ),
        ("a grid out of range", four(), stump("1").replace("grid 0 0", "grid 2201 0"), 4, "got \"grid 2201 0\""),
        (
            "a grid too fine",
            four(),
            stump("1").replace("grid 0 0", "grid 60 0"),
            4,
            "on this grid a tree may cost 2^61 or more",
        ),
        (
            "a grid that overflows",
            four(),
            stump("1").replace("grid 0 0", "grid 2000 2000"),
            4,
            "on this grid a tree may",
        ),
        ("a claim below 0", four(), stump("-1"), 5, "got \"claim -1\", expected \"claim\" and one whole"),
        ("a claim beyond 64 bits", four(), stump("99999999999999999999"), 5, "got \"claim 9999"),
        ("a claim of 2^61", four(), stump("2305843009213693952"), 5, "got \"claim 2305843009213693952\""),
        ("no claim", four(), stump("1").replace("claim 1\n", ""), 5, "got \"N 1 1 1\", expected \"claim\""),
    ]
}

/// Numbers written out: unit 4, costs 5, rows 6, weights 7, penalty 8, claim 9.
fn bad_numbers() -> Vec<BadLog> {
    let out = |old: &str, new: &str| written_out(&WRITTEN_OUT.replacen(old, new, 1));
    vec![
        ("no unit", tenths(), out("unit 10", "unit ten"), 4, "got \"unit ten\", expected \"unit\" and one exponent"),
        (
            "a cost that is no number",
            tenths(),
            out("0 1 1 0", "0 1 NaN 0"),
            5,
            "got \"costs 0 1 NaN 0\", expected \"costs\"",
        ),
        ("a cost below 0", tenths(), out("0 1 1 0", "0 -1 1 0"), 5, "got \"costs 0 -1 1 0\""),
        (
            "a cost too few",
            tenths(),
            out("0 1 1 0", "0 1 1"),
            5,
            "got 3 costs, expected rows of 2: from 2 rows to 1026",
        ),
        ("a class without costs", tenths(), out("0 1 1 0", "0 1"), 5, "got 2 costs, expected rows of 2"),
        ("too many rows", tenths(), out("0 1 1 0", &["0"; 2056].join(" ")), 5, "got 2056 costs, expected rows of 2"),
        (
            "a row that is not there",
            tenths(),
            out("rows 0 1", "rows 0 2"),
            6,
            "got 4 rows of samples, expected 4 below 2",
        ),
        ("a row too few", tenths(), out("rows 0 1", "rows 0"), 6, "got 3 rows of samples, expected 4 below 2"),
        ("a weight too many", tenths(), out("weights 102", "weights 102 1"), 7, "got 5 weights, expected 4"),
        (
            "a weight too large",
            tenths(),
            out("weights 102", "weights 103"),
            7,
            "sample 0, class 1: 103 x 1 is above the true",
        ),
        (
            "a cost too large",
            tenths(),
            out("0 1 1 0", "0 1 2 0"),
            7,
            "sample 1, class 0: 102 x 2 is above the true cost",
        ),
        ("a price for the right label", tenths(), out("0 1 1 0", "0 1 1 1"), 7, "sample 1, class 1: 102 x 1 is above"),
        (
            "a row of another class",
            tenths(),
            out("rows 0 1", "rows 1 1"),
            7,
            "sample 0, class 0: 102 x 1 is above the true",
        ),
        (
            "a unit too coarse",
            tenths(),
            out("unit 10", "unit 9"),
            7,
            "sample 0, class 1: 102 x 1 is above the true cost",
        ),
        (
            "sums beyond the capacity",
            tenths(),
            out("unit 10", "unit 64").replace("102", "1152921504606846975"),
            7,
            "with these weights a tree may cost 4611686018427387900, expected less than 2^61",
        ),
        ("a penalty too large", tenths(), out("penalty 0", "penalty 1"), 8, "the penalty 1 is above the problem's, 0"),
    ]
}

/// Axis-aligned bodies, from line 6.
fn bad_axis_bodies() -> Vec<BadLog> {
    let two_leaves = || Question { leaf_size: 2, ..stripes(4, 1) };
    vec![
        ("more than label sets prove", levels(), axis("3", "N 2 1 3 | E | end"), 6, "cut 1 of feature 0: 2, not 3"),
        ("no body", four(), axis("1", "end"), 6, "got \"end\", expected N and 3 numbers"),
        ("a bound that is no number", four(), axis("1", "N 1 1 x | E | end"), 6, "got \"N 1 1 x\", expected N and 3"),
        ("a bound below 0", four(), axis("1", "N 1 1 -1 | E | end"), 6, "got \"N 1 1 -1\", expected N and 3 numbers"),
        ("another depth", four(), axis("1", "N 2 1 1 | E | end"), 6, "expected depth 1, leaves of 1"),
        ("another leaf size", two_leaves(), axis("2", "N 1 3 2 | E | end"), 6, "expected depth 1, leaves of 2 or 1"),
        // With leaves of any size one goes wrong, with leaves of two two do.
        ("smaller leaves cost less", two_leaves(), axis("2", "N 1 1 2 | E | end"), 6, "a tree costs 1, not 2"),
        (
            "larger leaves in a record of any",
            Question { leaf_size: 2, ..stripes(10, 3) },
            axis("1", &format!("N 3 1 1 | K 0 5 | {} | E | end", halves(2))),
            9,
            "expected depth 2, leaves of 1",
        ),
        // What is proven of leaves of two need not hold of more samples.
        (
            "larger leaves do not grow",
            Question { leaf_size: 2, ..stripes(10, 3) },
            axis("1", &format!("N 3 2 1 | K 0 5 | {} | E | end", halves(2))),
            6,
            "cut 2 of feature 0: 0, not 1",
        ),
        ("too high a claim", four(), stump("2"), 6, "a tree costs 1, not 2"),
        ("a leaf that is cheaper", six(), axis("4", "N 2 1 4 | E | end"), 6, "a tree costs 3, not 4"),
        ("a bound below the claim", four(), axis("1", "N 1 1 0 | E | end"), 6, "this proves 0, not 1"),
        ("no end of a node", four(), axis("1", "N 1 1 1 | end"), 7, "got \"end\", expected E and 0 numbers"),
        // All six in two runs cost two wrong, so a side that lacks one sample costs one, and one that lacks two
        // nothing.
        ("no cut at all", six(), axis("1", "N 2 1 1 | E | end"), 6, "cut 2 of feature 0: 0, not 1"),
        // Of cut 3 either side costs 1; of cut 1 that is all that is known of its right side.
        (
            "a cut that proves too little",
            six(),
            axis("2", "N 2 1 2 | F 0 3 | E | end"),
            6,
            "cut 1 of feature 0: 1, not 2",
        ),
        (
            "a feature that is not there",
            six(),
            axis("1", "N 2 1 1 | F 7 3 | E | end"),
            7,
            "feature 7 has no cut 3 here",
        ),
        ("an empty side", six(), axis("1", "N 2 1 1 | F 0 6 | E | end"), 7, "feature 0 has no cut 6 here"),
        (
            "steps beyond 64 bits",
            six(),
            axis("1", &format!("N 2 1 1 | F 0 3 {} | E | end", i64::MAX)),
            7,
            "feature 0 has no cut",
        ),
        // Without the right side of cut 5 nothing bounds the right sides of cuts 1 to 4, and their left ones cost
        // nothing.
        (
            "a side too few",
            stripes(10, 3),
            axis("1", "N 3 1 1 | K 0 5 | L | N 2 1 1 | F 0 2 1 | E | E | end"),
            6,
            "cut 1 of feature 0: 0, not 1",
        ),
        (
            "a sensor that is not there",
            two_sensors(false),
            axis("1", "S 2 | end"),
            6,
            "sensor 2 cannot be decided here",
        ),
        ("a sensor twice", two_sensors(false), axis("1", "S 0 | S 0 | end"), 7, "sensor 0 cannot be decided here"),
        ("a case too few", two_sensors(false), axis("1", "S 0 | N 1 1 2 | E | end"), 9, "got \"end\", expected N"),
        ("no end", four(), axis("1", "N 1 1 1 | E"), 8, "got \"\", expected end"),
        ("more after the end", four(), axis("1", "N 1 1 1 | E | end | end"), 9, "got \"end\" after the end"),
    ]
}

/// Two-feature bodies, from line 6.
fn bad_two_feature_bodies() -> Vec<BadLog> {
    let body = |body: &str| two_feature("1", &format!("C 0 1 | {CUT} | {body}"));
    let halving = format!("C 0 1 | {}N 0 0 | end", "R 0 0 | ".repeat(1001));
    vec![
        ("a leaf of less", corners(1), two_feature("3", "D | end"), 5, "one leaf costs 2, less than the claim"),
        ("a line of less", corners(1), two_feature("2", "D | end"), 6, "a single split is not proven to cost 2"),
        (
            "a dual plane too few",
            corners(2),
            two_feature("0", "C 0 1 | N 0 0 | end"),
            8,
            "got \"end\", expected \"C 0 2\"",
        ),
        ("more than a section", corners(1), two_feature("1", "D | N 0 0 | end"), 7, "got \"N 0 0\", expected the next"),
        (
            "a line sensor twice",
            two_sensors(true),
            two_feature("1", "S 0 | S 0 | D"),
            7,
            "sensor 0 cannot be decided here",
        ),
        ("a node too few", runs(1), body("N 0 1 | end"), 8 + 1, "cannot read \"nothing\" here"),
        ("a word that is no tag", runs(1), body("X | end"), 8, "cannot read \"X\" here"),
        ("one number of two", runs(1), body("N 0 | N 1 0 | end"), 8, "expected 2 numbers, got \"0\""),
        ("settled samples that cost less", runs(1), body("N 0 0 | N 1 0 | end"), 8, "this proves 0, not 1"),
        (
            "settled samples said to cost more",
            runs(1),
            body("N 1 0 | N 1 0 | end"),
            8,
            "child 0 is not proven to cost 1",
        ),
        // Three open samples can cost three: 1 + 2 - 3.
        ("open samples that cost more", runs(1), body("W 1 2 | N 1 0 | end"), 8, "this proves 0, not 1"),
        ("open samples said to cost more", runs(1), body("W 9 9 | N 1 0 | end"), 8, "child 0 is not proven to cost 9"),
        (
            "a child that is cheap",
            runs(1),
            body("r 1 0 | N 0 1 | N 1 0 | end"),
            8,
            "a child of 0 does not bring the tree",
        ),
        (
            "a child said to cost more",
            runs(1),
            body("r 2 2 | N 0 1 | N 1 0 | end"),
            8,
            "a child is not proven to cost 2",
        ),
        ("samples enough for two leaves", runs(1), body("F | N 1 0 | end"), 8, "both children may hold 1 samples"),
        // Leaves of three: below 5/16 both children may hold as many.
        ("leaves that are just large enough", runs(3), body("F | F | end"), 8, "both children may hold 3 samples"),
        ("a slope on an axis", runs(1), body("T 0 | N 0 1 | N 0 1 | N 1 0 | end"), 8, "t = 0 is outside the region"),
        (
            "a slope that is no number",
            runs(1),
            body("T NaN | N 0 1 | N 0 1 | N 1 0 | end"),
            8,
            "t = NaN is outside the region",
        ),
        (
            "an edge far away",
            runs(1),
            body("R 9 0 | N 0 1 | N 0 1 | N 1 0 | end"),
            8,
            "the edge [9.0, 0.0] is beyond all",
        ),
        (
            "an edge that is no number",
            runs(1),
            body("R NaN 0 | N 0 1 | N 0 1 | N 1 0 | end"),
            8,
            "the edge [NaN, 0.0] is",
        ),
        ("nodes without end", runs(1), two_feature("1", &halving), 1007, "expected 1000 nodes in one another at most"),
        (
            "too many open samples",
            parabola(),
            two_feature("0", "C 0 1 | E | C 0 2 | E | C 1 0 | E | C 1 2 | E | end"),
            7,
            "50 open samples are too many to part",
        ),
        (
            "a dichotomy left out",
            runs(1),
            two_feature("1", &format!("C 0 1 | {CUT} | R .1875 .1875 | N 0 1 | E 0:0 | N 1 0 | end")),
            10,
            "the dichotomy 1 is left out, but a line makes it",
        ),
        (
            "a dichotomy said to cost more",
            runs(1),
            two_feature("1", &format!("C 0 1 | {CUT} | R .1875 .1875 | N 0 1 | E 0:1 1:1 | N 1 0 | end")),
            10,
            "the dichotomy 0 is not proven to cost 1",
        ),
    ]
}

#[test]
fn each_bad_log_is_refused_in_its_line_and_for_its_reason() {
    let wrong = bad_logs().into_iter().filter_map(|(name, question, log, line, reason)| {
        let refusal = run(&question, &log).err();
        let is_so = refusal.as_ref().is_some_and(|got| got.line == line && got.reason.starts_with(reason));
        (!is_so).then(|| format!("{name}: {refusal:?}, expected line {line}: {reason}"))
    });
    assert_eq!(wrong.collect::<Vec<_>>(), Vec::<String>::new());
}

/// Every sentence of a refusal in the sources is the reason of one of the logs above.
#[test]
fn no_refusal_goes_without_a_log() {
    let mut reasons: Vec<String> =
        bad_logs().iter().map(|(name, question, log, ..)| run(question, log).expect_err(name).reason).collect();
    reasons.extend(crate::regression::reasons());
    let sentences = sentences_of_refusals();
    assert!(sentences.len() > 30, "{sentences:?}");
    // What depends on the machine and not on the log.
    for sentence in sentences.iter().filter(|sentence| !sentence.starts_with("no thread")) {
        assert!(reasons.iter().any(|reason| fits(reason, sentence)), "no log is refused with {sentence:?}");
    }
}

/// Whether the fixed parts of a sentence, those between the braces, come in a reason in their order.
fn fits(reason: &str, sentence: &str) -> bool {
    let parts = sentence.split('{').map(|part| part.split_once('}').map_or(part, |(_, fixed)| fixed));
    let mut rest = Some(reason);
    parts.for_each(|part| rest = rest.and_then(|rest| rest.split_once(part)).map(|(_, after)| after));
    rest.is_some()
}
