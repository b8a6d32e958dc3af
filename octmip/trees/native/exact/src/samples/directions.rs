//! Distance of the gains of one cost profile from being in proportion to those of another.
//!
//! Samples whose gains are all `t * v` for one direction `v` and any t >= 0 move the gain of each label in a straight
//! line as they pass a cut one after the other, so that the best gains of both sides together are convex in how much
//! has passed, and largest before the first or after the last. What a sample's gains differ from that, at the best t
//! and up to a number that is the same for all labels, adds its span (largest less smallest) to that at most.

/// Twice the span that is left of each profile beside each direction, rounded up (`n_directions * n_profiles`).
///
/// The directions are the profiles' own: sums of two as well proved no tree faster. `gains` of one sample of each
/// profile (`n_profiles * n_labels`).
pub(crate) fn doubled_spans(gains: &[i64], n_labels: usize) -> Vec<i64> {
    let profiles: Vec<&[i64]> = gains.chunks(n_labels).collect();
    profiles.iter().flat_map(|v| profiles.iter().map(|profile| doubled_span(profile, v))).collect()
}

/// The least of `2 span(profile - t v)` over t >= 0, rounded up.
///
/// It is convex in t and made of straight pieces that end where two labels are equal: there, or at 0, is the least.
fn doubled_span(profile: &[i64], v: &[i64]) -> i64 {
    let mut ends = vec![(0i128, 1i128)];
    for (&a, &va) in profile.iter().zip(v) {
        for (&b, &vb) in profile.iter().zip(v) {
            let (over, under) = (i128::from(a) - i128::from(b), i128::from(va) - i128::from(vb));
            if under > 0 && over > 0 {
                ends.push((over, under));
            }
        }
    }
    let span = |&(over, under): &(i128, i128)| {
        let rest = || profile.iter().zip(v).map(|(&g, &v)| under * i128::from(g) - over * i128::from(v));
        let span = rest().max().unwrap_or(0) - rest().min().unwrap_or(0);
        (2 * span + under - 1).div_euclid(under)
    };
    ends.iter().map(span).min().unwrap_or(0) as i64
}
