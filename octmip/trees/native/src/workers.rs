//! Workers of other processes, as a search asks them: what submits a task to them, and the first error of one.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::call::PyCallArgs;
use pyo3::prelude::*;

/// Time for which a future is waited for before anything else is looked at.
const LOOK: Duration = Duration::from_millis(20);

/// Whoever does tasks for this process.
pub(crate) struct Workers {
    submit: Py<PyAny>,
    failed: Mutex<Option<PyErr>>,
}

impl Workers {
    /// Behind a callable that takes a task's arguments and returns its future (`octmip.trees.methods.cluster.Future`).
    pub(crate) fn new(submit: Py<PyAny>) -> Self {
        Self { submit, failed: Mutex::new(None) }
    }

    /// The result of a task; None when it was given up, as `waits` says, or has failed.
    pub(crate) fn ask<T>(&self, arguments: impl for<'py> PyCallArgs<'py>, waits: &dyn Fn() -> bool) -> Option<T>
    where
        T: for<'a, 'py> FromPyObject<'a, 'py, Error = PyErr>,
    {
        self.checked(self.result(arguments, waits)).flatten()
    }

    fn result<T>(&self, arguments: impl for<'py> PyCallArgs<'py>, waits: &dyn Fn() -> bool) -> PyResult<Option<T>>
    where
        T: for<'a, 'py> FromPyObject<'a, 'py, Error = PyErr>,
    {
        let future = Python::attach(|py| self.submit.call1(py, arguments))?;
        let wait = || Python::attach(|py| future.call_method1(py, "wait", (LOOK.as_secs_f64(),))?.extract::<bool>(py));
        while !wait()? {
            if !waits() {
                Python::attach(|py| future.call_method0(py, "cancel"))?;
                return Ok(None);
            }
        }
        Python::attach(|py| future.call_method0(py, "result")?.extract(py)).map(Some)
    }

    /// What was found; None where it is an error, the first of which is kept.
    pub(crate) fn checked<T>(&self, found: PyResult<T>) -> Option<T> {
        match found {
            Ok(found) => Some(found),
            Err(raised) => {
                self.lock().get_or_insert(raised);
                None
            }
        }
    }

    /// Whether a task has failed.
    pub(crate) fn has_failed(&self) -> bool {
        self.lock().is_some()
    }

    /// Raise the error, if there is one.
    pub(crate) fn finish(self) -> PyResult<()> {
        self.failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
    }

    fn lock(&self) -> MutexGuard<'_, Option<PyErr>> {
        self.failed.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
