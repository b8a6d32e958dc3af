//! An independent checker of octmip's proof logs.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

pub mod json;
pub mod question;
pub mod sha256;
