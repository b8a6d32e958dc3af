//! Lines of a proof log that both exact cores write; the formats are docs/theory/proof.md's and two-feature.md's.

use std::fmt::{Arguments, Write};

/// The body of a log as it grows.
#[derive(Debug, Default)]
pub struct Body(String);

impl Body {
    /// Write one line.
    pub fn line(&mut self, line: Arguments<'_>) {
        self.write(line);
        self.0.push('\n');
    }

    /// Write a part of a line.
    pub fn write(&mut self, part: Arguments<'_>) {
        // Writing to a string cannot fail.
        let _ = self.0.write_fmt(part);
    }

    /// A sensor is decided: what follows first is without it, then with it.
    pub fn decide(&mut self, sensor: usize) {
        self.line(format_args!("S {sensor}"));
    }

    /// Append whole lines.
    pub fn append(&mut self, lines: &str) {
        self.0.push_str(lines);
    }

    /// The lines written.
    pub fn into_lines(self) -> String {
        self.0
    }
}
