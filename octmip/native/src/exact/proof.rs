//! The proof log: the search once more, its budget at the claim, writing down every cut that it solved.
//!
//! The format is docs/theory/proof.md's; `octmip_check` reads it and knows nothing of what stands here. Children are
//! searched without the bounds of their neighbours (`floor` 0), as a record must stand by itself; the checker carries
//! bounds from cut to cut on its own.

use crate::exact::effort::Control;
use crate::exact::node::log::Log;
use crate::exact::node::search::Search;
use crate::exact::root_search::sensor_sets::{Relaxed, Sets};
use crate::exact::samples::Samples;
use crate::exact::samples::merging::merged;
use crate::exact::switches::Switches;
use crate::exact::view::View;
use crate::log::Body;
use crate::problem::Problem;

/// The body of a log that proves `claim`, None if it was stopped or the claim does not hold.
pub fn write(problem: &Problem, claim: i64, switches: Switches, control: &Control) -> Option<String> {
    let smaller = if switches.merging { merged(problem) } else { None };
    let samples = match smaller {
        Some((smaller, rows)) => Samples::new(&smaller).in_units_of(&smaller).of_rows(rows),
        None => Samples::new(problem).in_units_of(problem),
    };
    let upper = samples.counted(claim - samples.base.iter().sum::<i64>());
    let mut out = Body::default();
    if problem.sensor_cost.iter().sum::<f64>() > problem.sensor_limit {
        let sets = Sets::new(problem, &samples, switches, control, None, upper);
        sets.prove(&mut out)?;
    } else {
        out.append(&record(&samples, switches, control, problem.depth, upper)?);
    }
    (!control.is_stopped()).then(|| out.into_lines())
}

/// The record that no tree over these features costs less than `upper` above the base, as the samples count.
pub(crate) fn record(
    samples: &Samples,
    switches: Switches,
    control: &Control,
    depth: usize,
    upper: i64,
) -> Option<String> {
    let view = View::root(samples);
    let mut search = Search::new(samples, switches, control, depth);
    search.log = Some(Log::default());
    let result = search.solve(&view, depth, upper, i64::MIN);
    let record = search.log.as_mut().and_then(Log::take);
    record.filter(|_| result.lower >= upper && !control.is_stopped())
}

impl Sets<'_> {
    /// Write the tree of decisions over sensors, a record at each leaf; None when it cannot be proven.
    fn prove(&self, out: &mut Body) -> Option<()> {
        let mut open = self.take_open();
        while let Some(choice) = open.pop() {
            match self.relax(&choice, self.best().0) {
                Relaxed::Closed(features) => {
                    let samples = self.samples.with_features(&features);
                    let depth = self.problem.depth;
                    out.append(&record(&samples, self.switches, self.control, depth, self.best().0)?);
                }
                Relaxed::Within(..) => return None,
                Relaxed::Breaking(sensors) => {
                    let (sensor, without, with) = self.decide(&choice, &sensors)?;
                    out.decide(sensor);
                    open.push(with);
                    open.push(without);
                }
            }
        }
        Some(())
    }
}
