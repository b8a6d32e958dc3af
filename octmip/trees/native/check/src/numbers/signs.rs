//! Signs of sums of products, exactly.

use std::cmp::Ordering;

/// A number with the sign of the exact sum of some products, none of which underflows.
///
/// Every product is itself rounded plus a remainder that fused arithmetic finds exactly. The sum is kept as numbers
/// that do not overlap, from small to large: a new one is added to each in turn, the rounding staying behind (Shewchuk
/// 1997).
pub(crate) fn quick_sign<const N: usize>(products: [(f64, f64); N]) -> f64 {
    let mut parts: Vec<f64> = Vec::with_capacity(2 * N);
    for (a, b) in products {
        let product = a * b;
        for mut carry in [a.mul_add(b, -product), product] {
            for part in &mut parts {
                let sum = carry + *part;
                let added = sum - carry;
                *part = (carry - (sum - added)) + (*part - added);
                carry = sum;
            }
            parts.push(carry);
        }
    }
    parts.into_iter().rev().find(|&part| part != 0.0).unwrap_or(0.0)
}

/// The sign of a sum of products `a * b * 2^e` of any finite numbers.
///
/// Each is a whole number of up to 106 bits times a power of two; they are added as digits to the base 2^32.
pub fn exact_sign(products: &[(f64, f64, i32)]) -> Ordering {
    let wholes: Vec<(i128, i32)> = products
        .iter()
        .map(|&(a, b, e)| {
            let ((m, p), (n, q)) = (whole(a), whole(b));
            (i128::from(m) * i128::from(n), p + q + e)
        })
        .filter(|product| product.0 != 0)
        .collect();
    let exponents = || wholes.iter().map(|product| product.1);
    let (Some(least), Some(most)) = (exponents().min(), exponents().max()) else {
        return Ordering::Equal;
    };
    let mut digits = vec![0i128; (most - least) as usize / 32 + 6];
    for (number, exponent) in wholes {
        let (first, shift) = ((exponent - least) as usize / 32, (exponent - least) % 32);
        for (k, digit) in digits[first..first + 4].iter_mut().enumerate() {
            let part = (number.unsigned_abs() >> (32 * k)) as u32;
            *digit += i128::from(u64::from(part) << shift) * number.signum();
        }
    }
    let (mut carry, mut is_zero) = (0, true);
    for digit in digits {
        let sum = digit + carry;
        is_zero &= sum.trailing_zeros() >= 32;
        carry = sum >> 32;
    }
    // The highest digits are left free, so what is carried out of them is the sign: -1 or 0.
    if carry < 0 {
        Ordering::Less
    } else if is_zero && carry == 0 {
        Ordering::Equal
    } else {
        Ordering::Greater
    }
}

/// A finite number as a whole one times 2 to a power.
fn whole(number: f64) -> (i64, i32) {
    let bits = number.to_bits();
    let (fraction, biased) = ((bits & ((1 << 52) - 1)) as i64, (bits >> 52 & 0x7ff) as i32);
    let (size, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
    (if number < 0.0 { -size } else { size }, exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_right_to_the_last_bit() {
        let next = 1.0 - f64::EPSILON / 2.0;
        assert!(quick_sign([(next, next), (-1.0, 1.0), (f64::EPSILON, 1.0)]) > 0.0);
        assert_eq!(quick_sign([(next, next), (-next, next), (0.0, 1.0)]), 0.0);
        assert!(quick_sign([(1e-130, 1e-130), (-1e-130, 1.1e-130)]) < 0.0);
    }

    #[test]
    fn signs_are_right_over_the_whole_range_of_numbers() {
        let (least, most) = (5e-324, f64::MAX);
        let sign = |products: &[(f64, f64, i32)]| exact_sign(products);
        assert_eq!(sign(&[(most, most, 0), (-most, most, 0)]), Ordering::Equal);
        assert_eq!(sign(&[(most, most, 0), (-most, most, 0), (least, least, 0)]), Ordering::Greater);
        assert_eq!(sign(&[(most, most, 0), (-most, most, 0), (-least, least, -2000)]), Ordering::Less);
        assert_eq!(sign(&[(1.0, 1.0, 3), (-8.0, 1.0, 0)]), Ordering::Equal);
        assert_eq!(sign(&[(1.0, 1.0, -1), (1.0, 1.0, -1), (-1.0, 1.0, 0)]), Ordering::Equal);
        assert_eq!(sign(&[(3.0, 1.0, 0), (-3.0, 1.0, 0), (-1e-300, 1e-300, 0)]), Ordering::Less);
        assert_eq!(sign(&[(-0.0, 1.0, 0), (0.0, -1.0, 5)]), Ordering::Equal);
        assert_eq!(sign(&[]), Ordering::Equal);
    }
}
