//! Random small problems, their optima by trying every tree, and the cost of a tree counted sample by sample.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

use std::collections::HashMap;
use std::sync::Arc;

use octmip_check::problem::{Planes, Problem};
use octmip_check::question::Question;
use octmip_frame::tree::{Node, Tree};

/// So many problems of each kind.
pub const N_CASES: u64 = 45;

/// A set of samples: sample i is in it where bit i is set.
type Set = u32;

/// A problem as it is given to the checker, and as it is given to the solvers.
pub struct Case {
    /// As the checker reads it.
    pub question: Question,
    /// As the solvers read it.
    pub problem: Problem,
}

/// A problem of ranks, one feature after the other, whose rows are of some classes: a mistake costs 1, and depth is 2.
pub fn problem_of_ranks(ranks: &[u32], labels: &[u32]) -> Problem {
    let (n, k) = (labels.len(), labels.iter().max().map_or(1, |most| *most as usize + 1));
    let p = ranks.len() / n;
    let n_values = |f: usize| ranks[f * n..][..n].iter().max().map_or(0, |most| most + 1);
    Problem {
        n,
        p,
        n_classes: k,
        ranks: Arc::new(ranks.to_vec()),
        n_ranks: (0..p).map(n_values).collect(),
        labels: labels.to_vec(),
        weights: vec![1; n],
        costs: (0..k * k).map(|at| i64::from(at % (k + 1) != 0)).collect(),
        penalty: 0,
        depth: 2,
        leaf_size: 1,
        sensor_of_feature: (0..p as u32).collect(),
        sensor_cost: vec![1.0; p],
        sensor_limit: f64::INFINITY,
        allowed: vec![true; p],
        planes: None,
    }
}

/// Draw problems, each with its seed.
pub fn random_cases(depth: usize, split_size: usize) -> impl Iterator<Item = (u64, Case)> {
    let stream = (10 * depth + split_size) as u64 * 1000;
    (stream..stream + N_CASES)
        .map(move |seed| (seed, random_case(&mut fastrand::Rng::with_seed(seed), depth, split_size)))
}

/// A log of what a solver wrote, as Python puts it together.
pub fn log_of(question: &Question, claim: i64, body: &str) -> String {
    let kind = if question.is_hyperplane { " two-feature" } else { "" };
    let (data, asked) = (question.data_digest(), question.question_digest());
    format!("octmip-proof 3{kind}\ndata {data}\nquestion {asked}\ngrid 0 0\nclaim {claim}\n{body}end\n")
}

/// Draw a problem: few samples on a small grid, so that there are ties, duplicates and points on one line.
pub fn random_case(rng: &mut fastrand::Rng, depth: usize, split_size: usize) -> Case {
    let (n, p, k) = (rng.usize(4..9), rng.usize(split_size..4), rng.usize(2..4));
    let features: Vec<f64> = (0..n * p).map(|_| f64::from(rng.i32(0..4))).collect();
    let mut costs: Vec<f64> = (0..k * k).map(|_| f64::from(rng.i32(1..3))).collect();
    (0..k).for_each(|c| costs[c * k + c] = 0.0);
    let has_budget = p > 1 && rng.bool();
    let question = Question {
        n,
        p,
        n_classes: k,
        features,
        labels: (0..n).map(|_| rng.u32(0..k as u32)).collect(),
        weights: (0..n).map(|_| f64::from(rng.i32(1..4))).collect(),
        costs,
        depth,
        is_hyperplane: split_size > 1,
        split_size,
        leaf_size: if rng.u8(0..3) == 0 { 2 } else { 1 },
        leaf_penalty: f64::from(rng.i32(0..2)),
        sensor_of_feature: (0..p as u32).collect(),
        sensor_cost: (0..p).map(|_| f64::from(rng.i32(1..4))).collect(),
        sensor_limit: if has_budget { f64::from(rng.i32(2..6)) } else { f64::INFINITY },
        allowed_splits: None,
    };
    let question = question.validated().expect("a valid problem");
    Case { problem: problem_of(&question), question }
}

/// The same with four to six classes and up to ten samples: costs are distances of the classes, or drawn without any
/// order, so that the cheapest label of a class may be another one, and labels cover one another.
pub fn case_of_many_labels(rng: &mut fastrand::Rng, depth: usize) -> Case {
    let mut question = random_case(rng, depth, 1).question;
    let (k, n) = (rng.usize(4..7), rng.usize(6..11));
    let distance = |e: usize| (e / k).abs_diff(e % k) as f64;
    question.costs = (0..k * k).map(|e| if rng.u64(0..3) > 0 { distance(e) } else { 0.0 }).collect();
    if rng.bool() {
        question.costs = (0..k * k).map(|_| f64::from(rng.i32(0..5))).collect();
    }
    question.features = (0..n * question.p).map(|_| f64::from(rng.i32(0..4))).collect();
    question.labels = (0..n).map(|_| rng.u32(0..k as u32)).collect();
    question.weights = (0..n).map(|_| f64::from(rng.i32(1..4))).collect();
    (question.n, question.n_classes) = (n, k);
    let question = question.validated().expect("a valid problem");
    Case { problem: problem_of(&question), question }
}

/// The same with leaves of a least size among more samples, so that the free optimum seldom has such leaves.
pub fn case_of_large_leaves(rng: &mut fastrand::Rng, depth: usize) -> Case {
    let mut question = if rng.bool() { random_case(rng, depth, 1) } else { case_of_many_labels(rng, depth) }.question;
    let (p, k, n) = (question.p, question.n_classes, rng.usize(8..15));
    question.features = (0..n * p).map(|_| f64::from(rng.i32(0..4))).collect();
    question.labels = (0..n).map(|_| rng.u32(0..k as u32)).collect();
    let most = if rng.bool() { 2 } else { 5 };
    question.weights = (0..n).map(|_| f64::from(rng.i32(1..most))).collect();
    (question.n, question.leaf_size) = (n, rng.usize(2..5));
    let question = question.validated().expect("a valid problem");
    Case { problem: problem_of(&question), question }
}

fn problem_of(question: &Question) -> Problem {
    let column = |f: usize| (0..question.n).map(move |i| question.features[i * question.p + f] as usize);
    let distinct: Vec<Vec<usize>> =
        (0..question.p).map(|f| (0..4).filter(|v| column(f).any(|x| x == *v)).collect()).collect();
    let rank = |f: usize, x: usize| distinct[f].iter().take_while(|&&v| v < x).count() as u32;
    let problem = Problem {
        n: question.n,
        p: question.p,
        n_classes: question.n_classes,
        ranks: Arc::new(
            (0..question.p).flat_map(|f| column(f).map(move |x| (f, x))).map(|(f, x)| rank(f, x)).collect(),
        ),
        n_ranks: distinct.iter().map(|values| values.len() as u32).collect(),
        labels: question.labels.clone(),
        weights: question.weights.iter().map(|&weight| weight as i64).collect(),
        costs: question.costs.iter().map(|&cost| cost as i64).collect(),
        penalty: question.leaf_penalty as i64,
        depth: question.depth,
        leaf_size: question.leaf_size,
        sensor_of_feature: question.sensor_of_feature.clone(),
        sensor_cost: question.sensor_cost.clone(),
        sensor_limit: question.sensor_limit,
        allowed: vec![true; question.p],
        planes: (question.split_size > 1).then(|| Planes {
            values: question.features.clone(),
            split_size: question.split_size,
            groups: None,
            integer_normals: None,
        }),
    };
    problem.validate().expect("a valid problem");
    problem
}

/// The least cost of a tree, over all sets of sensors that can be paid for.
pub fn optimum(problem: &Problem) -> i64 {
    let is_paid = |set: &u32| {
        let sensors = (0..problem.p).filter(|f| set >> f & 1 == 1);
        sensors.map(|f| problem.sensor_cost[f]).sum::<f64>() <= problem.sensor_limit
    };
    let best = |features: u32| {
        let splits = splits(problem, features);
        Enumerator { problem, splits, best: HashMap::new() }.best((1 << problem.n) - 1, problem.depth)
    };
    (0..1 << problem.p).filter(is_paid).map(best).min().expect("a tree without sensors")
}

/// All ways of parting all the samples, each with the number of features that it takes.
fn splits(problem: &Problem, features: u32) -> Vec<(Set, i64)> {
    let chosen = || (0..problem.p).filter(|f| features >> f & 1 == 1);
    let side = |is_left: &dyn Fn(usize) -> bool| (0..problem.n).filter(|&i| is_left(i)).map(|i| 1 << i).sum::<Set>();
    let mut found = Vec::new();
    for f in chosen() {
        let ranks = problem.feature(f);
        found.extend((0..problem.n_ranks[f]).map(|cut| (side(&|i| ranks[i] <= cut), 1)));
    }
    for (f, g) in
        chosen().flat_map(|f| chosen().map(move |g| (f, g))).filter(|(f, g)| problem.planes.is_some() && f < g)
    {
        let at = |i: usize| (problem.row(i as u32)[f] as i64, problem.row(i as u32)[g] as i64);
        for (a, b) in (0..problem.n).flat_map(|a| (0..problem.n).map(move |b| (a, b))).filter(|&(a, b)| at(a) != at(b))
        {
            // A line through two points, turned a little about a place on it: those left of it, and those on it up to
            // the place, or from it on (which is the pair in its other order).
            let ((ax, ay), (bx, by)) = (at(a), at(b));
            let turn = |i: usize| (bx - ax) * (at(i).1 - ay) - (by - ay) * (at(i).0 - ax);
            let along = |i: usize| (bx - ax) * (at(i).0 - ax) + (by - ay) * (at(i).1 - ay);
            found.extend((0..problem.n).filter(|&c| turn(c) == 0).flat_map(|c| {
                let up_to = side(&|i| turn(i) > 0 || (turn(i) == 0 && along(i) <= along(c)));
                [(up_to, 2), (side(&|i| turn(i) > 0), 2)]
            }));
        }
    }
    found.sort_unstable();
    found.dedup();
    found
}

struct Enumerator<'a> {
    problem: &'a Problem,
    splits: Vec<(Set, i64)>,
    best: HashMap<(Set, usize), i64>,
}

impl Enumerator<'_> {
    /// The least cost of a tree of `depth` levels on a set of samples.
    fn best(&mut self, set: Set, depth: usize) -> i64 {
        if let Some(&known) = self.best.get(&(set, depth)) {
            return known;
        }
        let q = self.problem;
        let paid =
            |k| (0..q.n).filter(|i| set >> i & 1 == 1).map(|i| q.weights[i] * q.cost(q.labels[i] as usize, k)).sum();
        let mut best: i64 = (0..q.n_classes).map(paid).min().expect("a class");
        for (left, n_features) in if depth > 0 { self.splits.clone() } else { Vec::new() } {
            let sides = [set & left, set & !left];
            if sides.iter().all(|side| side.count_ones() as usize >= q.leaf_size) {
                let cost = self.best(sides[0], depth - 1) + self.best(sides[1], depth - 1);
                best = best.min(cost + n_features * q.penalty);
            }
        }
        self.best.insert((set, depth), best);
        best
    }
}

/// What a tree costs, counted sample by sample; None if a leaf is too small, a path too long or the sensors too
/// expensive.
pub fn cost_of(problem: &Problem, tree: &Tree) -> Option<i64> {
    let mut leaves = vec![0; tree.nodes.len()];
    let mut cost = 0;
    for i in 0..problem.n {
        let (mut at, mut depth) = (0, 0);
        let label = loop {
            match &tree.nodes[at] {
                Node::Leaf { label } => break *label as usize,
                node => at = next(problem, node, i),
            }
            depth += 1;
        };
        leaves[at] += 1;
        cost += problem.weights[i] * problem.cost(problem.labels[i] as usize, label);
        if depth > problem.depth {
            return None;
        }
    }
    let features: Vec<u32> = tree.nodes.iter().flat_map(features_of).collect();
    let is_read = |f: &usize| features.contains(&(*f as u32));
    let sensors: f64 = (0..problem.p).filter(is_read).map(|f| problem.sensor_cost[f]).sum();
    let is_small = |(node, n): (&Node, &usize)| matches!(node, Node::Leaf { .. }) && *n < problem.leaf_size;
    let is_wrong = sensors > problem.sensor_limit || tree.nodes.iter().zip(&leaves).any(is_small);
    (!is_wrong).then_some(cost + problem.penalty * features.len() as i64)
}

fn next(problem: &Problem, node: &Node, sample: usize) -> usize {
    let (is_left, left, right) = match node {
        Node::Leaf { .. } => (true, &0, &0),
        Node::Split { feature, cut, left, right } => (problem.feature(*feature as usize)[sample] <= *cut, left, right),
        Node::Hyperplane { terms, offset, left, right } => {
            let row = problem.row(sample as u32);
            (terms.iter().map(|(f, c)| row[*f as usize] * c).sum::<f64>() <= *offset, left, right)
        }
    };
    (if is_left { *left } else { *right }) as usize
}

fn features_of(node: &Node) -> Vec<u32> {
    match node {
        Node::Leaf { .. } => Vec::new(),
        Node::Split { feature, .. } => vec![*feature],
        Node::Hyperplane { terms, .. } => terms.iter().map(|term| term.0).collect(),
    }
}
