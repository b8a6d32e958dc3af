//! `octmip-check LOG PROBLEM.json [--threads N]`: check a proof log against the problem file that
//! `octmip solve --write-problem` wrote.
//!
//! Exit code 0: the log proves its bound. 1: it is refused, and one line says where and why. 2: a file cannot be used.
#![forbid(unsafe_code)]

use std::ffi::OsString;
use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use octmip_check::question::Question;
use octmip_check::regression::question::RegressionQuestion;
use octmip_check::{Refusal, Report, check, regression};

const USAGE: &str =
    "usage: octmip-check LOG PROBLEM.json [--threads N] (files of octmip solve --proof and --write-problem)";

/// Most threads that can be asked for.
const MOST_THREADS: usize = 1024;

fn main() -> ExitCode {
    let arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
    let (files, n_threads) = match &arguments[..] {
        [log, problem] => ([log, problem], std::thread::available_parallelism().map_or(1, usize::from)),
        [log, problem, option, number] if option == "--threads" => match number.to_str().and_then(threads) {
            Some(n_threads) => ([log, problem], n_threads),
            None => {
                eprintln!("octmip-check: got {number:?} threads, expected 1 to {MOST_THREADS}; {USAGE}");
                return ExitCode::from(2);
            }
        },
        _ => {
            eprintln!("octmip-check: got {} arguments, expected 2, or 4 with --threads; {USAGE}", arguments.len());
            return ExitCode::from(2);
        }
    };
    let [log, problem] = files.map(Path::new);
    match run(log, problem, n_threads) {
        Ok(Ok((report, seconds))) => {
            println!("{}", verified(&report, seconds));
            ExitCode::SUCCESS
        }
        Ok(Err(refusal)) => {
            println!("{}, line {}: {}; the proof is refused", log.display(), refusal.line, refusal.reason);
            ExitCode::from(1)
        }
        Err(fault) => {
            eprintln!("octmip-check: {fault}");
            ExitCode::from(2)
        }
    }
}

/// The number of threads that a word names.
fn threads(word: &str) -> Option<usize> {
    word.parse().ok().filter(|n_threads| (1..=MOST_THREADS).contains(n_threads))
}

/// Check a log: what it proves and the seconds that took, or the refusal; the error says which file cannot be used.
fn run(log: &Path, problem: &Path, n_threads: usize) -> Result<Result<(Report, f64), Refusal>, String> {
    let start = Instant::now();
    let text = read(log, "a proof log of octmip solve --proof")?;
    let text = String::from_utf8_lossy(&text);
    let file = read(problem, "a problem file of octmip solve --write-problem")?;
    let fault = |reason: String| {
        let path = problem.display();
        format!("{path}: {reason}; expected a problem file; write it again with octmip solve --write-problem")
    };
    let file = String::from_utf8(file).map_err(|error| fault(format!("the file is no UTF-8 ({error})")))?;
    let checked = if RegressionQuestion::is_file(&file) {
        regression::check(&RegressionQuestion::from_json(&file).map_err(fault)?, &text)
    } else {
        check(&Question::from_json(&file).map_err(fault)?, &text, n_threads)
    };
    Ok(checked.map(|report| (report, start.elapsed().as_secs_f64())))
}

fn read(path: &Path, expected: &str) -> Result<Vec<u8>, String> {
    let fault = |error| format!("{}: {error}; expected {expected}; check the path", path.display());
    std::fs::read(path).map_err(fault)
}

fn verified(report: &Report, seconds: f64) -> String {
    let bound = format!("{:?}", report.bound);
    let bound = bound.strip_suffix(".0").unwrap_or(&bound);
    format!("verified: no tree costs less than {bound} ({} lines, {seconds:.2} s)", report.n_lines)
}
