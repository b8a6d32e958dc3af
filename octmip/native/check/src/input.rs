//! The problem as it was given, read from its file, and the digests that bind a log to it.

mod digests;
mod json;
mod problem_file;
pub mod question;
mod sha256;
