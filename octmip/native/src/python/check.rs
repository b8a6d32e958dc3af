//! The checker of proof logs, for Python.

use pyo3::prelude::*;

use super::PyProblem;
use crate::check::check;
use crate::check_lines;

/// The line and the reason why a log does not prove that every tree costs `claim`; none when it does.
#[pyfunction]
#[pyo3(name = "check")]
pub fn py_check(py: Python<'_>, problem: &PyProblem, log: &str, skip: usize, claim: i64) -> Option<(usize, String)> {
    let refusal = py.detach(|| check(&problem.inner, log, skip, claim).err());
    refusal.map(|refusal| (refusal.0, refusal.1))
}

/// The line and the reason why a log does not prove that every two-feature tree costs `claim`; none when it does.
#[pyfunction]
#[pyo3(name = "check_lines")]
pub fn py_check_lines(
    py: Python<'_>,
    problem: &PyProblem,
    log: &str,
    skip: usize,
    claim: i64,
    threads: usize,
) -> Option<(usize, String)> {
    let check = || check_lines::check(&problem.inner, log, skip, claim, threads.max(1));
    py.detach(check).err().map(|refusal| (refusal.0, refusal.1))
}
