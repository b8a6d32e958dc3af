//! The proof log: the search once more, its budget at the claim, writing down every cut that it solved.
//!
//! The format is docs/theory/proof.md's; `octmip_check` reads it and knows nothing of what stands here. Children are
//! searched without the bounds of their neighbours (`floor` 0), as a record must stand by itself; the checker carries
//! bounds from cut to cut on its own.

use std::fmt::Write;

use crate::exact::Switches;
use crate::exact::branch::Search;
use crate::exact::budget::{Relaxed, Sets};
use crate::exact::effort::Control;
use crate::exact::samples::Samples;
use crate::exact::view::View;
use crate::problem::Problem;

/// The records of a search: those below the node in work, and that of the node last closed.
#[derive(Debug, Default)]
pub struct Log {
    body: String,
    last: Option<String>,
}

impl Log {
    /// Begin a node; what is returned is to be given back to `close`.
    pub fn open(&mut self) -> String {
        self.last = None;
        std::mem::take(&mut self.body)
    }

    /// Close a node: every tree of `depth` levels with leaves of `leaf_size` costs `bound` or more.
    pub fn close(&mut self, outer: String, depth: usize, leaf_size: usize, bound: i64) {
        let body = std::mem::replace(&mut self.body, outer);
        self.last = Some(format!("N {depth} {leaf_size} {}\n{body}E\n", bound.max(0)));
    }

    /// Leave a node without a record.
    pub fn pass_over(&mut self, outer: String) {
        self.body = outer;
        self.last = None;
    }

    /// The record of the node last closed, None when it was passed over.
    pub fn take(&mut self) -> Option<String> {
        self.last.take()
    }

    /// The same samples, one level less.
    pub fn shallower(&mut self) {
        if let Some(record) = self.last.take() {
            self.body.push_str("B\n");
            self.body.push_str(&record);
        }
    }

    /// Cuts whose stumps were counted, by number of samples on the left.
    pub fn counted(&mut self, feature: u32, cuts: &mut [u32]) {
        cuts.sort_unstable();
        if cuts.is_empty() {
            return;
        }
        let _ = write!(self.body, "F {feature}");
        let mut last = 0;
        for &cut in cuts.iter() {
            let _ = write!(self.body, " {}", cut - last);
            last = cut;
        }
        self.body.push('\n');
    }

    /// A cut with the records of its sides.
    pub fn cut(&mut self, feature: u32, position: usize, sides: [Option<String>; 2]) {
        if sides.iter().all(Option::is_none) {
            return;
        }
        let _ = writeln!(self.body, "K {feature} {position}");
        for (tag, record) in ["L\n", "R\n"].into_iter().zip(sides) {
            if let Some(record) = record {
                self.body.push_str(tag);
                self.body.push_str(&record);
            }
        }
    }
}

/// The body of a log that proves `claim`, None if it was stopped or the claim does not hold.
pub fn write(problem: &Problem, claim: i64, switches: Switches, control: &Control) -> Option<String> {
    let samples = Samples::new(problem);
    let upper = claim - samples.base.iter().sum::<i64>();
    let switches = Switches { mixed_labels: switches.mixed_labels && is_plain(problem), ..switches };
    let mut out = String::new();
    if problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit {
        let sets = Sets::new(problem, &samples, switches, control, None, upper);
        sets.prove(&mut out)?;
    } else {
        out.push_str(&record(&samples, switches, control, problem.depth, upper)?);
    }
    (!control.is_stopped()).then_some(out)
}

/// The record that no tree over these features costs less than `upper` above the base.
pub fn record(samples: &Samples, switches: Switches, control: &Control, depth: usize, upper: i64) -> Option<String> {
    let view = View::root(samples);
    let mut search = Search::new(samples, switches, control, depth);
    search.log = Some(Log::default());
    let answer = search.solve(&view, depth, upper, i64::MIN);
    let record = search.log.as_mut().and_then(Log::take);
    record.filter(|_| answer.lower >= upper && !control.is_stopped())
}

/// Whether a wrong answer costs the same whichever it is: then columns are classes, for the checker as for the search.
fn is_plain(problem: &Problem) -> bool {
    (0..problem.n_classes).all(|class| {
        let mut wrong = (0..problem.n_classes).filter(|&k| k != class).map(|k| problem.cost(class, k));
        let first = wrong.next().unwrap_or(1);
        wrong.all(|cost| cost == first) && first > problem.cost(class, class)
    })
}

impl Sets<'_> {
    /// Write the tree of decisions over sensors, a record at each leaf; None when it cannot be proven.
    fn prove(&self, out: &mut String) -> Option<()> {
        let mut open = self.take_open();
        while let Some(choice) = open.pop() {
            match self.relax(&choice, self.best().0) {
                Relaxed::Closed(features) => {
                    let samples = self.samples.with_features(&features);
                    let depth = self.problem.depth;
                    out.push_str(&record(&samples, self.switches, self.control, depth, self.best().0)?);
                }
                Relaxed::Within(..) => return None,
                Relaxed::Breaking(sensors) => {
                    let (sensor, without, with) = self.decide(&choice, &sensors)?;
                    let _ = writeln!(out, "S {sensor}");
                    open.push(with);
                    open.push(without);
                }
            }
        }
        Some(())
    }
}
