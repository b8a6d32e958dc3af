//! `octmip-check LOG PROBLEM.json`: what it prints, and its exit codes.

use std::path::PathBuf;
use std::process::Command;

use octmip_check::question::Question;
use octmip_check::regression::question::RegressionQuestion;

/// Four samples of classes 0 and 1 in turn, a tree of depth 1: one goes wrong.
const PROBLEM: &str = r#"{"format": "octmip-problem", "version": 1, "feature_names": ["x"], "class_names": ["a", "b"],
"features": [[0.0], [1.0], [2.0], [3.0]], "labels": [0, 1, 0, 1], "weights": [1.0, 1.0, 1.0, 1.0],
"costs": [[0.0, 1.0], [1.0, 0.0]], "depth": 1, "split": "axis", "split_size": 1, "leaf_size": 1, "leaf_penalty": 0.0,
"sensor_of_feature": [0], "sensor_cost": [1.0], "sensor_limit": null, "allowed_splits": null}"#;

fn log(claim: i64) -> String {
    let question = Question::from_json(PROBLEM).expect("a problem file");
    let (data, asked) = (question.data_digest(), question.question_digest());
    format!("octmip-proof 3\ndata {data}\nquestion {asked}\ngrid 0 0\nclaim {claim}\nN 1 1 {claim}\nE\nend\n")
}

/// Write the files, unless they are none, and run the command: exit code, standard output, standard error.
fn run(name: &str, log: Option<&str>, problem: Option<&str>) -> (Option<i32>, String, String) {
    run_bytes(name, log.map(str::as_bytes), problem.map(str::as_bytes))
}

fn run_bytes(name: &str, log: Option<&[u8]>, problem: Option<&[u8]>) -> (Option<i32>, String, String) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let files = [("proof.log", log), ("problem.json", problem)].map(|(name, text)| {
        text.into_iter().for_each(|text| std::fs::write(folder.join(name), text).expect("a file"));
        folder.join(name)
    });
    let mut command = Command::new(env!("CARGO_BIN_EXE_octmip-check"));
    let done = command.args(files).args(["--threads", "2"]).output().expect("the command runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (done.status.code(), text(done.stdout), text(done.stderr))
}

#[test]
fn a_proof_is_verified_in_one_line() {
    let (code, out, err) = run("good", Some(&log(1)), Some(PROBLEM));
    assert_eq!((code, err.as_str()), (Some(0), ""));
    assert!(out.starts_with("verified: no tree costs less than 1 (8 lines, "), "{out}");
    assert!(out.ends_with(" s)\n") && out.lines().count() == 1, "{out}");
}

#[test]
fn a_proof_is_refused_with_its_line_and_the_reason() {
    let (code, out, err) = run("bad", Some(&log(2)), Some(PROBLEM));
    assert_eq!((code, err.as_str()), (Some(1), ""));
    assert!(out.ends_with("proof.log, line 6: a tree costs 1, not 2; the proof is refused\n"), "{out}");
    let (code, out, _) = run("other", Some(&log(1)), Some(&PROBLEM.replace("[3.0]]", "[4.0]]")));
    assert!(code == Some(1) && out.contains("proof.log, line 2: got \"data "), "{out}");
}

/// Targets 0 9 0 9, a tree of depth 1: one is missed by 9.
const NUMBERS: &str = r#"{"format": "octmip-regression-problem", "version": 1, "feature_names": ["x"],
"target_name": "y", "features": [[0.0], [1.0], [2.0], [3.0]], "targets": [0, 9, 0, 9], "weights": [1, 1, 1, 1],
"loss": "absolute", "depth": 1, "leaf_size": 1, "leaf_penalty": 0, "sensor_of_feature": [0], "sensor_cost": [1],
"sensor_limit": null}"#;

#[test]
fn a_proof_of_a_regression_problem_is_verified_or_refused() {
    let question = RegressionQuestion::from_json(NUMBERS).expect("a problem file");
    let (data, asked) = (question.data_digest(), question.question_digest());
    let log = |claim: i64| {
        format!(
            "octmip-proof 3 regression absolute\ndata {data}\nquestion {asked}\ngrid 0 0 0 1100\nclaim {claim}\n\
             N 1 1 {claim}\nE\nend\n"
        )
    };
    let (code, out, _) = run("numbers", Some(&log(9)), Some(NUMBERS));
    assert!(code == Some(0) && out.starts_with("verified: no tree costs less than 9 (8 lines, "), "{out}");
    let (code, out, _) = run("numbers_raised", Some(&log(10)), Some(NUMBERS));
    assert!(code == Some(1) && out.ends_with("line 6: a tree costs 9, not 10; the proof is refused\n"), "{out}");
    let changes = [
        ("absolute", "huber", "loss is \"huber\""),
        ("absolute", "quantile:9/9", "loss is \"quantile:9/9\""),
        ("absolute", "quantile:0.9", "or a quantile such as \"quantile:9/10\""),
        ("version\": 1", "version\": 2", "version is not 1 to 1"),
        ("[0, 9, 0, 9]", "[0, 9, 0]", "targets has 3 entries, expected 4"),
        ("\"weights\": [1", "\"weights\": [-1", "weights holds -1"),
        ("depth\": 1", "depth\": 0", "depth is 0"),
        ("feature\": [0]", "feature\": [1]", "sensor_of_feature holds 1"),
    ];
    for (old, new, sentence) in changes {
        assert!(NUMBERS.contains(old), "{old}");
        let (code, _, err) = run("numbers_wrong", Some(&log(9)), Some(&NUMBERS.replacen(old, new, 1)));
        assert!(code == Some(2) && err.contains(sentence), "{sentence}: {err}");
    }
}

#[test]
fn files_that_cannot_be_used_are_named() {
    let (code, out, err) = run("broken", Some(&log(1)), Some(&PROBLEM.replace("\"depth\": 1", "\"depth\": 0")));
    assert_eq!((code, out.as_str()), (Some(2), ""));
    let sentence = "problem.json: depth is 0, expected 1 to 30; expected a problem file; write it again with octmip";
    assert!(err.starts_with("octmip-check: ") && err.contains(sentence), "{err}");
    let (code, _, err) = run("missing", None, Some(PROBLEM));
    assert!(code == Some(2) && err.contains("expected a proof log of octmip solve --proof; check the path"), "{err}");
}

#[test]
fn a_problem_file_of_bytes_that_are_no_text_is_named() {
    let file = PROBLEM.replace("\"a\", \"b\"", "\"a\", \"?\"");
    let bytes: Vec<u8> = file.bytes().map(|byte| if byte == b'?' { 0xbe } else { byte }).collect();
    let (code, out, err) = run_bytes("bytes", Some(log(1).as_bytes()), Some(&bytes));
    assert_eq!((code, out.as_str()), (Some(2), ""));
    assert!(err.contains("problem.json: the file is no UTF-8 (invalid utf-8 sequence of 1 bytes from index "), "{err}");
}

#[test]
fn other_arguments_are_refused_with_the_usage() {
    let done = Command::new(env!("CARGO_BIN_EXE_octmip-check")).arg("one").output().expect("the command runs");
    let err = String::from_utf8_lossy(&done.stderr).into_owned();
    assert_eq!(done.status.code(), Some(2));
    let sentence =
        "octmip-check: got 1 arguments, expected 2, or 4 with --threads; usage: octmip-check LOG PROBLEM.json";
    assert!(err.starts_with(sentence), "{err}");
    for number in ["0", "many", "-1", "1025", "99999999999999999999"] {
        let arguments = ["proof.log", "problem.json", "--threads", number];
        let done = Command::new(env!("CARGO_BIN_EXE_octmip-check")).args(arguments).output().expect("the command runs");
        let err = String::from_utf8_lossy(&done.stderr).into_owned();
        assert_eq!(done.status.code(), Some(2));
        assert!(err.contains(&format!("got {number:?} threads, expected 1 to 1024")), "{err}");
    }
}
