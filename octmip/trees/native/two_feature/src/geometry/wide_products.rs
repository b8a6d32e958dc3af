//! Products of 128-bit whole numbers, compared exactly.

use std::cmp::Ordering;

/// Compare `a * b` with `c * d`.
pub(crate) fn compare_products(a: i128, b: i128, c: i128, d: i128) -> Ordering {
    let (first, second) = (product(a, b), product(c, d));
    match (first.0, second.0) {
        (false, true) => Ordering::Greater,
        (true, false) => Ordering::Less,
        (false, false) => first.1.cmp(&second.1),
        (true, true) => second.1.cmp(&first.1),
    }
}

/// Whether the product is negative, and its size as (high, low) 128 bits.
fn product(a: i128, b: i128) -> (bool, (u128, u128)) {
    let size = multiply(a.unsigned_abs(), b.unsigned_abs());
    ((a < 0) != (b < 0) && size != (0, 0), size)
}

fn multiply(a: u128, b: u128) -> (u128, u128) {
    const LOW: u128 = u64::MAX as u128;
    let (a1, a0, b1, b0) = (a >> 64, a & LOW, b >> 64, b & LOW);
    let (low, cross1, cross2) = (a0 * b0, a1 * b0, a0 * b1);
    let middle = (low >> 64) + (cross1 & LOW) + (cross2 & LOW);
    let high = a1 * b1 + (cross1 >> 64) + (cross2 >> 64) + (middle >> 64);
    (high, (middle << 64) | (low & LOW))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn products_beyond_128_bits_compare_as_they_should() {
        let big = 1i128 << 119;
        assert_eq!(compare_products(big, big + 1, big + 1, big), Ordering::Equal);
        assert_eq!(compare_products(big + 1, big + 1, big + 2, big), Ordering::Greater);
        assert_eq!(compare_products(-big, big, big, big), Ordering::Less);
        assert_eq!(compare_products(-big, big + 1, big, -big), Ordering::Less);
        assert_eq!(compare_products(0, -5, 3, 0), Ordering::Equal);
    }

    #[test]
    fn high_and_low_halves_are_those_of_the_schoolbook() {
        assert_eq!(multiply(u128::MAX, u128::MAX), (u128::MAX - 1, 1));
        assert_eq!(multiply(3 << 64, 5 << 64), (15, 0));
    }
}
