//! Samples with the lowest, the true and the highest rank of every reading.
//!
//! The ranks of a feature are those of all three kinds together, so that a cut "rank <= c" says of each kind which
//! samples lie below it. A sample may go left if its lowest rank is at most c, right if its highest is above c.

use crate::problem::Problem;

/// Ranks of the lowest and highest readings, feature-major as the problem's own, and how many gauges may be off.
#[derive(Debug, Clone)]
pub struct Bands {
    /// Rank of the lowest reading of every sample (`p * n`).
    pub low: Vec<u32>,
    /// Rank of the highest reading (`p * n`).
    pub high: Vec<u32>,
    /// Most sensors that are off at a time, 1 or more.
    pub n_off: usize,
    /// Labels that a leaf may have; the columns of the costs beyond are no answers.
    pub n_labels: usize,
}

impl Bands {
    /// What is wrong with them, if anything.
    pub fn complaint(&self, problem: &Problem) -> Option<String> {
        let (n, size) = (problem.n, problem.n * problem.p);
        if self.low.len() != size || self.high.len() != size {
            return Some(format!("bands have {} and {} ranks, expected {size}", self.low.len(), self.high.len()));
        }
        if self.n_off == 0 || self.n_labels == 0 || self.n_labels > problem.n_classes {
            return Some(format!("{} sensors off and {} labels are out of range", self.n_off, self.n_labels));
        }
        let is_ordered = |k: usize| {
            self.low[k] <= problem.ranks[k] && problem.ranks[k] <= self.high[k] && self.high[k] < problem.n_ranks[k / n]
        };
        (0..size).find(|&k| !is_ordered(k)).map(|k| format!("the ranks of entry {k} are not in order"))
    }
}

/// A sample passes a cut that moves up: with its lowest reading, with its true one, with its highest.
pub(crate) const LOW: usize = 0;
/// See `LOW`.
pub(crate) const TRUE: usize = 1;
/// See `LOW`.
pub(crate) const HIGH: usize = 2;

/// One sample at one rank.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Event {
    /// The rank.
    pub(crate) rank: u32,
    place: u32,
}

impl Event {
    fn new(rank: u32, sample: usize, kind: usize) -> Self {
        Self { rank, place: (sample as u32) << 2 | kind as u32 }
    }

    /// The sample.
    pub(crate) fn sample(self) -> usize {
        (self.place >> 2) as usize
    }

    /// `LOW`, `TRUE` or `HIGH`.
    pub(crate) fn kind(self) -> usize {
        (self.place & 3) as usize
    }
}

/// A feature that splits may read.
#[derive(Debug)]
pub(crate) struct Feature {
    /// Its index in the problem.
    pub(crate) index: u32,
    /// The sensor that gives it.
    pub(crate) sensor: usize,
    /// Lowest, true and highest rank of every sample.
    pub(crate) ranks: [Vec<u32>; 3],
    /// Samples by their true rank.
    pub(crate) order: Vec<u32>,
    /// All events by rank.
    pub(crate) events: Vec<Event>,
    /// Number of ranks.
    pub(crate) n_ranks: usize,
}

impl Feature {
    fn new(problem: &Problem, bands: &Bands, f: usize) -> Self {
        let (n, range) = (problem.n, f * problem.n..(f + 1) * problem.n);
        let ranks = [bands.low[range.clone()].to_vec(), problem.feature(f).to_vec(), bands.high[range].to_vec()];
        let mut order: Vec<u32> = (0..n as u32).collect();
        order.sort_by_key(|&i| ranks[TRUE][i as usize]);
        let each = |kind: usize| ranks[kind].iter().enumerate().map(move |(i, &rank)| Event::new(rank, i, kind));
        let mut events: Vec<Event> = (0..3).flat_map(each).collect();
        events.sort_by_key(|event| (event.rank, event.place));
        let (index, n_ranks) = (f as u32, problem.n_ranks[f] as usize);
        Self { index, sensor: problem.sensor_of_feature[f] as usize, ranks, order, events, n_ranks }
    }

    /// The lowest and the highest cut with at least so many of some samples on either side; none where no cut has.
    pub(crate) fn window(&self, leaf_size: usize, is_member: impl Fn(usize) -> bool) -> Option<(u32, u32)> {
        let rank = |&i: &u32| self.ranks[TRUE][i as usize];
        let members = |&&i: &&u32| is_member(i as usize);
        let lowest = self.order.iter().filter(members).nth(leaf_size - 1).map(rank)?;
        let highest = self.order.iter().rev().filter(members).nth(leaf_size - 1).map(rank)?;
        (lowest < highest).then(|| (lowest, highest - 1))
    }

    /// Which way a sample goes at a cut: may it go left, may it go right.
    pub(crate) fn ways(&self, sample: usize, cut: u32, is_off: bool) -> (bool, bool) {
        if is_off {
            (self.ranks[LOW][sample] <= cut, self.ranks[HIGH][sample] > cut)
        } else {
            let is_left = self.ranks[TRUE][sample] <= cut;
            (is_left, !is_left)
        }
    }
}

/// A problem and its bands, as the searches use them.
#[derive(Debug)]
pub(crate) struct Instance {
    /// Number of samples.
    pub(crate) n: usize,
    /// Number of rows of the costs.
    pub(crate) n_rows: usize,
    /// Number of labels.
    pub(crate) n_labels: usize,
    /// Levels of splits.
    pub(crate) depth: usize,
    /// Fewest samples in a leaf, by their true readings.
    pub(crate) leaf_size: usize,
    /// Price of a split.
    pub(crate) penalty: i64,
    /// Most sensors that are off at a time.
    pub(crate) n_off: usize,
    /// Row of the costs of each sample.
    pub(crate) rows: Vec<u32>,
    /// Weight of each sample.
    pub(crate) weights: Vec<i64>,
    costs: Vec<i64>,
    /// The usable features.
    pub(crate) features: Vec<Feature>,
    sensor_cost: Vec<f64>,
    sensor_limit: f64,
}

impl Instance {
    /// The instance of a problem and bands that have no complaint.
    pub(crate) fn new(problem: &Problem, bands: &Bands) -> Self {
        let is_usable = |&f: &usize| {
            let price = problem.sensor_cost[problem.sensor_of_feature[f] as usize];
            problem.allowed[f] && price <= problem.sensor_limit
        };
        let features = (0..problem.p).filter(is_usable).map(|f| Feature::new(problem, bands, f));
        let rows = problem.costs.chunks(problem.n_classes);
        Self {
            n: problem.n,
            n_rows: problem.n_classes,
            n_labels: bands.n_labels,
            depth: problem.depth,
            leaf_size: problem.leaf_size,
            penalty: problem.penalty,
            n_off: bands.n_off,
            rows: problem.labels.clone(),
            weights: problem.weights.clone(),
            costs: rows.flat_map(|row| row[..bands.n_labels].iter().copied()).collect(),
            features: features.filter(|feature| feature.window(problem.leaf_size, |_| true).is_some()).collect(),
            sensor_cost: problem.sensor_cost.clone(),
            sensor_limit: problem.sensor_limit,
        }
    }

    /// Cost of a label for one unit of weight of a row.
    pub(crate) fn cost(&self, row: usize, label: usize) -> i64 {
        self.costs[row * self.n_labels + label]
    }

    /// Cost of a label for a sample.
    pub(crate) fn paid(&self, sample: usize, label: usize) -> i64 {
        self.weights[sample] * self.cost(self.rows[sample] as usize, label)
    }

    /// Whether some sensors are within the budget together; none is named twice.
    pub(crate) fn fits(&self, sensors: &[usize]) -> bool {
        sensors.iter().map(|&sensor| self.sensor_cost[sensor]).sum::<f64>() <= self.sensor_limit
    }

    /// The best leaf: cost and label, the first among equals.
    pub(crate) fn best_leaf(&self) -> (i64, usize) {
        let cost = |label: usize| (0..self.n).map(|i| self.paid(i, label)).sum::<i64>();
        (0..self.n_labels).map(|label| (cost(label), label)).min().unwrap_or((0, 0))
    }
}

/// Sorted, none twice.
pub(crate) fn distinct(sensors: impl IntoIterator<Item = usize>) -> Vec<usize> {
    let mut found: Vec<usize> = sensors.into_iter().collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// All subsets of so many sensors, or the one of all where there are fewer.
pub(crate) fn subsets(sensors: &[usize], size: usize) -> Vec<Vec<usize>> {
    if sensors.len() <= size {
        return vec![sensors.to_vec()];
    }
    if size == 0 {
        return vec![Vec::new()];
    }
    let mut found: Vec<Vec<usize>> = subsets(&sensors[1..], size - 1);
    found.iter_mut().for_each(|set| set.insert(0, sensors[0]));
    found.extend(subsets(&sensors[1..], size));
    found
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use fastrand::Rng;

    /// A random instance of depth 2: few values, so that readings and their bands often tie.
    pub(crate) fn random_instance(seed: u64) -> Instance {
        let mut rng = Rng::with_seed(seed);
        let (n, p, n_classes) = (12, 2, 3);
        let (mut low, mut ranks, mut high) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..p * n {
            let mut three = [rng.u32(0..8), rng.u32(0..8), rng.u32(0..8)];
            three.sort_unstable();
            low.push(three[0]);
            ranks.push(three[1]);
            high.push(three[2]);
        }
        let problem = Problem {
            n,
            p,
            n_classes,
            ranks: ranks.into(),
            n_ranks: vec![8; p],
            labels: (0..n).map(|_| rng.u32(0..3)).collect(),
            weights: (0..n).map(|_| rng.i64(0..4)).collect(),
            costs: (0..n_classes * n_classes).map(|_| rng.i64(0..6)).collect(),
            penalty: rng.i64(0..3),
            depth: 2,
            leaf_size: 1,
            sensor_of_feature: vec![0, rng.u32(0..2)],
            sensor_cost: vec![0.0; 2],
            sensor_limit: f64::INFINITY,
            allowed: vec![true; p],
            planes: None,
        };
        let bands = Bands { low, high, n_off: rng.usize(1..4), n_labels: n_classes };
        assert_eq!(bands.complaint(&problem), None);
        Instance::new(&problem, &bands)
    }

    #[test]
    fn sets_of_so_many_sensors_or_all() {
        assert_eq!(subsets(&[1, 4, 7], 2), [[1, 4], [1, 7], [4, 7]]);
        assert_eq!(subsets(&[1, 4], 3), [[1, 4]]);
        assert_eq!(distinct([4, 1, 4]), [1, 4]);
    }
}
