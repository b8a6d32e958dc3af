//! Lines of a proof log that both exact cores write; the formats are docs/theory/proof.md's and two-feature.md's.

use std::fmt::{Arguments, Write};

/// The body of a log as it grows.
#[derive(Debug, Default)]
pub(crate) struct Body(String);

impl Body {
    /// Write one line.
    pub(crate) fn line(&mut self, line: Arguments<'_>) {
        self.write(line);
        self.0.push('\n');
    }

    /// Write a part of a line.
    pub(crate) fn write(&mut self, part: Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(part);
    }

    /// A sensor is decided: what follows first is without it, then with it.
    pub(crate) fn decide(&mut self, sensor: usize) {
        self.line(format_args!("S {sensor}"));
    }

    /// Append whole lines.
    pub(crate) fn append(&mut self, lines: &str) {
        self.0.push_str(lines);
    }

    /// The lines written.
    pub(crate) fn into_lines(self) -> String {
        self.0
    }
}
