//! Records of a proof log: what a search proves of each node.

use octmip_frame::log::Body;

/// The records of a search: those below the node in work, and that of the node last closed.
#[derive(Debug, Default)]
pub(crate) struct Log {
    body: Body,
    last: Option<String>,
}

impl Log {
    /// Begin a node; returns the outer node's lines, which `close` takes back.
    pub(crate) fn open(&mut self) -> Body {
        self.last = None;
        std::mem::take(&mut self.body)
    }

    /// Add records that were written elsewhere.
    pub(crate) fn append(&mut self, lines: &str) {
        self.body.append(lines);
    }

    /// Close a node: every tree of `depth` levels with leaves of `leaf_size` costs `bound` or more.
    pub(crate) fn close(&mut self, outer: Body, depth: usize, leaf_size: usize, bound: i64) {
        let body = std::mem::replace(&mut self.body, outer).into_lines();
        self.last = Some(format!("N {depth} {leaf_size} {}\n{body}E\n", bound.max(0)));
    }

    /// The lines written since the node in work was opened, or since they were taken last.
    pub(crate) fn take_lines(&mut self) -> String {
        std::mem::take(&mut self.body).into_lines()
    }

    /// Leave a node without a record.
    pub(crate) fn pass_over(&mut self, outer: Body) {
        self.body = outer;
        self.last = None;
    }

    /// The record of the node last closed, None when it was passed over.
    pub(crate) fn take(&mut self) -> Option<String> {
        self.last.take()
    }

    /// Add the record of the same samples one level shallower.
    pub(crate) fn shallower(&mut self, record: Option<String>) {
        if let Some(record) = record {
            self.body.append("B\n");
            self.body.append(&record);
        }
    }

    /// Add cuts whose stumps were counted, by number of samples on the left.
    pub(crate) fn counted(&mut self, feature: u32, cuts: &mut [u32]) {
        cuts.sort_unstable();
        if cuts.is_empty() {
            return;
        }
        self.body.write(format_args!("F {feature}"));
        let mut last = 0;
        for &cut in cuts.iter() {
            self.body.write(format_args!(" {}", cut - last));
            last = cut;
        }
        self.body.append("\n");
    }

    /// Add a cut with records of its sides, each of one kind of leaves.
    pub(crate) fn cut(&mut self, feature: u32, position: usize, records: &[[Option<String>; 2]]) {
        if records.iter().flatten().all(Option::is_none) {
            return;
        }
        self.body.line(format_args!("K {feature} {position}"));
        for (side, tag) in ["L\n", "R\n"].into_iter().enumerate() {
            for record in records.iter().filter_map(|records| records[side].as_ref()) {
                self.body.append(tag);
                self.body.append(record);
            }
        }
    }
}
