//! The instance of a problem: coordinates, labels, weights, costs, and the dual planes that a split may come from.

use crate::geometry::plane::Plane;
use crate::loss::Loss;
use crate::switches::Switches;
use crate::weighted_samples::WeightedSamples;
use octmip_check::problem::Problem;

/// A problem in coordinates, with costs put into the weights where all mistakes cost the same.
#[derive(Debug, Clone)]
pub(crate) struct Instance {
    /// Coordinates.
    pub(crate) plane: Plane,
    /// Class of each sample.
    pub(crate) labels: Vec<u32>,
    /// Weight of each sample; one cost for all mistakes is in here too.
    pub(crate) weights: Vec<i64>,
    /// Costs and prices.
    pub(crate) loss: Loss,
    /// Coefficients become whole numbers of at most this size where some part the samples alike.
    pub(crate) preferred: Option<i64>,
    /// Prunes and bounds that are on.
    pub(crate) switches: Switches,
    /// Dual planes that a split may come from, as pairs of features; (f, p) is an axis-aligned split of f.
    pub(crate) dual_planes: Vec<(usize, usize)>,
}

impl Instance {
    /// The instance of a problem; without hyperplane splits in it, ranks serve as values.
    pub(crate) fn new(problem: &Problem) -> Self {
        let (loss, unit) = Loss::of(problem);
        let values = match problem.values_by_feature() {
            Some(values) => values,
            None => problem.ranks.iter().map(|&rank| f64::from(rank)).collect(),
        };
        Self {
            plane: Plane::new(problem.n, problem.p, &values, &problem.ranks),
            labels: problem.labels.clone(),
            weights: problem.weights.iter().map(|weight| weight * unit).collect(),
            loss,
            preferred: None,
            switches: Switches::default(),
            dual_planes: dual_planes_of(problem),
        }
    }

    /// The samples with the problem's own labels and weights.
    pub(crate) fn samples(&self) -> WeightedSamples<'_> {
        WeightedSamples {
            plane: &self.plane,
            labels: &self.labels,
            weights: &self.weights,
            loss: &self.loss,
            switches: self.switches,
        }
    }

    /// All samples.
    pub(crate) fn all(&self) -> Vec<u32> {
        (0..self.plane.n as u32).collect()
    }
}

/// The dual planes that the groups, the size of a split and the budget for a single split allow, axis-aligned ones
/// first.
fn dual_planes_of(problem: &Problem) -> Vec<(usize, usize)> {
    let p = problem.p;
    let axis = (0..p).map(|f| (f, p));
    let pairs = (0..p).flat_map(|f| (0..p).filter(move |&g| g != f).map(move |g| (f, g)));
    axis.chain(pairs)
        .filter(|&(f, g)| is_allowed(problem, f, g) && sensor_cost(problem, f, g) <= problem.sensor_limit)
        .collect()
}

/// Whether a split may use a feature, or two together (g = p: one).
pub(crate) fn is_allowed(problem: &Problem, f: usize, g: usize) -> bool {
    if g == problem.p {
        return problem.allowed[f];
    }
    let Some(planes) = problem.planes.as_ref().filter(|planes| planes.split_size >= 2) else {
        return false;
    };
    planes.groups.as_ref().is_none_or(|groups| {
        let has = |group: &Vec<u32>, f: usize| group.contains(&(f as u32));
        groups.iter().any(|group| has(group, f) && has(group, g))
    })
}

fn sensor_cost(problem: &Problem, f: usize, g: usize) -> f64 {
    let sensor = |f: usize| problem.sensor_of_feature[f] as usize;
    let first = problem.sensor_cost[sensor(f)];
    if g == problem.p || sensor(f) == sensor(g) { first } else { first + problem.sensor_cost[sensor(g)] }
}
