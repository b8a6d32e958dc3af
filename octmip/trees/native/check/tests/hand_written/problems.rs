//! The problems of the logs that are written by hand, and the sentences of the sources.

use octmip_check::question::Question;

/// Samples in the order of one feature, of classes 0 and 1 in turn; a wrong label costs 1.
pub fn stripes(n: usize, depth: usize) -> Question {
    Question {
        n,
        p: 1,
        n_classes: 2,
        features: (0..n).map(|i| i as f64).collect(),
        labels: (0..n as u32).map(|i| i % 2).collect(),
        weights: vec![1.0; n],
        costs: vec![0.0, 1.0, 1.0, 0.0],
        depth,
        is_hyperplane: false,
        split_size: 1,
        leaf_size: 1,
        leaf_penalty: 0.0,
        sensor_of_feature: vec![0],
        sensor_cost: vec![1.0],
        sensor_limit: f64::INFINITY,
        allowed_splits: None,
    }
}

/// Both sides of the middle of ten stripes, with leaves of a size: one of the five on either goes wrong.
pub fn halves(leaf: usize) -> String {
    let node = format!("N 2 {leaf} 1 | F 0 2 1 | E");
    format!("L | {node} | R | {node}")
}

/// Two samples of class 1 that lack their value, and 0 0 1 1 in the order of the feature.
pub fn missing(depth: usize) -> Question {
    let missing = f64::NAN;
    let features = vec![missing, 0.0, 1.0, 2.0, 3.0, missing];
    Question { features, labels: vec![1, 0, 0, 1, 1, 1], ..stripes(6, depth) }
}

/// Classes 0 2 4 0 2 4 of five levels in the order of the feature; a wrong label costs its distance.
pub fn levels() -> Question {
    let costs = (0..25).map(|e: i32| f64::from((e / 5 - e % 5).abs())).collect();
    Question { n_classes: 5, labels: vec![0, 2, 4, 0, 2, 4], costs, ..stripes(6, 2) }
}

/// Six stripes for two lines one after the other, each over one feature.
pub fn runs(leaf_size: usize) -> Question {
    Question { is_hyperplane: true, leaf_size, ..stripes(6, 2) }
}

/// The first line of a proof for `runs`: root lines below and above 5/16, between the third and the fourth sample.
pub const CUT: &str = "R .3125 .3125";

/// The corners of a square, the classes of neighbours different, split by lines over both features.
pub fn corners(depth: usize) -> Question {
    Question {
        p: 2,
        features: vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0],
        is_hyperplane: true,
        split_size: 2,
        sensor_of_feature: vec![0, 0],
        ..stripes(4, depth)
    }
}

/// Fifty points of which no three are on one line.
pub fn parabola() -> Question {
    let features = (0..50).flat_map(|i| [f64::from(i), f64::from(i * i)]).collect();
    let (labels, weights) = ((0..50).map(|i| i % 2).collect(), vec![1.0; 50]);
    Question { n: 50, features, labels, weights, ..corners(2) }
}

/// Four stripes and a second feature of one value; either is a sensor of its own, and one of them can be paid for.
pub fn two_sensors(is_hyperplane: bool) -> Question {
    let features = (0..4).flat_map(|i| [f64::from(i), 0.0]).collect();
    Question {
        p: 2,
        features,
        is_hyperplane,
        split_size: if is_hyperplane { 2 } else { 1 },
        sensor_of_feature: vec![0, 1],
        sensor_cost: vec![1.0, 1.0],
        sensor_limit: 1.0,
        ..stripes(4, 1)
    }
}

/// Four stripes of weight .1; a right label costs .5, a wrong one 1.5.
pub fn tenths() -> Question {
    Question { weights: vec![0.1; 4], costs: vec![0.5, 1.5, 1.5, 0.5], ..stripes(4, 1) }
}

/// What stands between the digests and the end of a log of `tenths`.
pub const WRITTEN_OUT: &str = "unit 10
costs 0 1 1 0
rows 0 1 0 1
weights 102 102 102 102
penalty 0
claim 102
N 1 1 102
E";

pub fn written_out(numbers: &str) -> String {
    format!("octmip-proof 3\ndata DATA\nquestion QUESTION\n{numbers}\nend\n")
}

/// The sentences of all refusals in the sources, as they stand there: of `ensure!` and of `reason: format!`.
pub fn sentences_of_refusals() -> Vec<String> {
    let mut found = Vec::new();
    for text in sources(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src")) {
        let code = text.split("#[cfg(test)]").next().unwrap_or("");
        let places = ["ensure!(", "reason: format!(", "let reason = || format!("];
        let places = places.iter().flat_map(|mark| code.match_indices(mark).map(|(at, _)| &code[at..]));
        for place in places.filter(|place| !place.contains("$($reason)*") || !place.starts_with("reason")) {
            let end = place.find(";\n").unwrap_or(place.len());
            // A sentence has blanks; what else is quoted before it has none.
            let quoted = place[..end].replace("\\\"", "'");
            found.extend(quoted.split('"').skip(1).step_by(2).find(|text| text.contains(' ')).map(String::from));
        }
    }
    found
}

fn sources(folder: &std::path::Path) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).expect("the sources are there") {
        let path = entry.expect("a file").path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else {
            found.push(std::fs::read_to_string(path).expect("text"));
        }
    }
    found
}
