//! A place in the lines of a log.

use crate::refusal::{Checked, ensure, shown};

/// The lines of a log, and how many of them have been read.
#[derive(Clone, Copy)]
pub(crate) struct Cursor<'a> {
    lines: &'a [&'a str],
    n_read: usize,
}

impl<'a> Cursor<'a> {
    pub(crate) fn new(lines: &'a [&'a str]) -> Self {
        Self { lines, n_read: 0 }
    }

    /// Number of the line read last, from 1.
    pub(crate) fn line(&self) -> usize {
        self.n_read
    }

    /// The next line, None at the end.
    pub(crate) fn peek(&self) -> Option<&'a str> {
        self.lines.get(self.n_read).copied()
    }

    /// Read a line; at the end, where it counts as read, None.
    pub(crate) fn read(&mut self) -> Option<&'a str> {
        self.n_read += 1;
        self.lines.get(self.n_read - 1).copied()
    }

    /// The numbers of the next line, if it has this tag and whole numbers of 0 or more; else it is not read.
    pub(crate) fn take(&mut self, tag: &str) -> Option<Vec<i64>> {
        let mut words = self.peek()?.split(' ');
        let numbers = if words.next()? == tag { words.map(whole_number).collect() } else { None };
        self.n_read += usize::from(numbers.is_some());
        numbers
    }

    /// The numbers of the next line, which must have this tag and so many numbers.
    pub(crate) fn expect<const N: usize>(&mut self, tag: &str) -> Checked<[i64; N]> {
        let (got, line) = (self.peek().unwrap_or(""), self.n_read + 1);
        let numbers = self.take(tag).and_then(|numbers| numbers.try_into().ok());
        ensure!(numbers.is_some(), line, "got {}, expected {tag} and {N} numbers", shown(got));
        Ok(numbers.unwrap_or([0; N]))
    }

    /// Check that the word `end` is all that is left.
    pub(crate) fn expect_end(&mut self) -> Checked<()> {
        let got = self.read();
        ensure!(got == Some("end"), self.n_read, "got {}, expected end", shown(got.unwrap_or("")));
        ensure!(self.peek().is_none(), self.n_read + 1, "got {} after the end", shown(self.peek().unwrap_or("")));
        Ok(())
    }

    /// The lines from here to one that `is_last` holds of, which is left to be read next.
    pub(crate) fn section(&mut self, is_last: impl Fn(&str) -> bool) -> Self {
        let begin = self.n_read;
        while self.peek().is_some_and(|line| !is_last(line)) {
            self.n_read += 1;
        }
        Self { lines: &self.lines[..self.n_read], n_read: begin }
    }
}

/// A whole number of 0 or more, written in digits alone.
pub(crate) fn whole_number(word: &str) -> Option<i64> {
    if word.bytes().all(|byte| byte.is_ascii_digit()) { word.parse().ok() } else { None }
}
