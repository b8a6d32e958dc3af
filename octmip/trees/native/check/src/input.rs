//! The problem as it was given, read from its file, and the digests that bind a log to it.

pub(crate) mod digests;
pub(crate) mod json;
pub(crate) mod problem_file;
pub mod question;
pub(crate) mod sha256;
