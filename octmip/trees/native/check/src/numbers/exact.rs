//! Numbers of 0 or more, exactly: a whole number of any length times a power of two, as every float64 is.

use std::cmp::Ordering;

/// `digits`, to the base 2^32 and the lowest first, times 2^`exponent`; neither first nor last digit is 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Exact {
    digits: Vec<u32>,
    exponent: i64,
}

impl Exact {
    fn new(mut digits: Vec<u32>, exponent: i64) -> Self {
        while digits.last() == Some(&0) {
            digits.pop();
        }
        let n_zeros = digits.iter().take_while(|&&digit| digit == 0).count();
        digits.drain(..n_zeros);
        let exponent = if digits.is_empty() { 0 } else { exponent + 32 * n_zeros as i64 };
        Self { digits, exponent }
    }

    /// A whole number.
    pub(crate) fn whole(number: u64) -> Self {
        Self::new(vec![number as u32, (number >> 32) as u32], 0)
    }

    /// The value of a finite float64 of 0 or more.
    pub(crate) fn of(number: f64) -> Self {
        debug_assert!(number.is_finite() && number >= 0.0);
        let bits = number.to_bits();
        let (fraction, biased) = (bits & ((1 << 52) - 1), (bits >> 52 & 0x7ff) as i64);
        let (size, exponent) = if biased == 0 { (fraction, -1074) } else { (fraction | 1 << 52, biased - 1075) };
        Self::whole(size).scaled(exponent)
    }

    /// The number times a power of two.
    pub(crate) fn scaled(mut self, power: i64) -> Self {
        self.exponent += if self.digits.is_empty() { 0 } else { power };
        self
    }

    /// The sum of two numbers.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let (mut sum, rest, exponent) = self.aligned(other);
        sum.resize(sum.len().max(rest.len()) + 1, 0);
        let mut carry = 0;
        for (digit, more) in sum.iter_mut().zip(rest.into_iter().chain(std::iter::repeat(0))) {
            carry += u64::from(*digit) + u64::from(more);
            *digit = carry as u32;
            carry >>= 32;
        }
        Self::new(sum, exponent)
    }

    /// The number less one that is not above it.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        debug_assert!(self >= other);
        let (mut left, rest, exponent) = self.aligned(other);
        let mut borrowed = 0;
        for (digit, less) in left.iter_mut().zip(rest.into_iter().chain(std::iter::repeat(0))) {
            let difference = i64::from(*digit) - i64::from(less) - borrowed;
            *digit = difference as u32;
            borrowed = i64::from(difference < 0);
        }
        Self::new(left, exponent)
    }

    /// The product of two numbers.
    pub(crate) fn times(&self, other: &Self) -> Self {
        let mut product = vec![0; self.digits.len() + other.digits.len()];
        for (i, &a) in self.digits.iter().enumerate() {
            let mut carry = 0;
            for (j, &b) in other.digits.iter().enumerate() {
                carry += u64::from(product[i + j]) + u64::from(a) * u64::from(b);
                product[i + j] = carry as u32;
                carry >>= 32;
            }
            product[i + other.digits.len()] = carry as u32;
        }
        Self::new(product, self.exponent + other.exponent)
    }

    /// The largest whole number that is not above it, None from 2^64 on.
    pub(crate) fn floor(&self) -> Option<u64> {
        if self.end() > 64 {
            return None;
        }
        let mut floor = 0;
        for (k, &digit) in self.digits.iter().enumerate() {
            let place = self.exponent + 32 * k as i64;
            let wide = u128::from(digit);
            floor |= match place {
                0.. => wide << place.min(64),
                -32..0 => wide >> -place,
                _ => 0,
            };
        }
        u64::try_from(floor).ok()
    }

    /// The largest float64 that is not above it.
    pub(crate) fn rounded_down(&self) -> f64 {
        if self.end() > 1024 {
            return f64::MAX;
        }
        // The place of the last binary digit that float64 has room for.
        let place = (self.end() - 53).max(-1074);
        let size = self.clone().scaled(-place).floor().unwrap_or(0);
        let is_normal = size >> 52 == 1;
        let biased = if is_normal { (place + 1075) as u64 } else { 0 };
        f64::from_bits(biased << 52 | size & ((1 << 52) - 1))
    }

    /// The power of two that is above it, and half of which is not.
    fn end(&self) -> i64 {
        let first = self.digits.last().map_or(0, |digit| 32 - i64::from(digit.leading_zeros()));
        self.exponent + 32 * (self.digits.len() as i64 - 1).max(0) + first
    }

    /// The digits of two numbers at the smaller of their exponents, and that exponent.
    fn aligned(&self, other: &Self) -> (Vec<u32>, Vec<u32>, i64) {
        let exponent = match (self.digits.is_empty(), other.digits.is_empty()) {
            (true, _) => other.exponent,
            (_, true) => self.exponent,
            _ => self.exponent.min(other.exponent),
        };
        (self.digits_from(exponent), other.digits_from(exponent), exponent)
    }

    fn digits_from(&self, exponent: i64) -> Vec<u32> {
        if self.digits.is_empty() {
            return Vec::new();
        }
        let shift = (self.exponent - exponent) as usize;
        let mut digits = vec![0; shift / 32];
        let mut carry = 0;
        for &digit in &self.digits {
            carry |= u64::from(digit) << (shift % 32);
            digits.push(carry as u32);
            carry >>= 32;
        }
        digits.push(carry as u32);
        digits
    }
}

impl Ord for Exact {
    fn cmp(&self, other: &Self) -> Ordering {
        match (self.digits.is_empty(), other.digits.is_empty()) {
            (false, false) => {}
            (one, another) => return another.cmp(&one),
        }
        self.end().cmp(&other.end()).then_with(|| {
            let (one, another, _) = self.aligned(other);
            let digits = |digits: &[u32], k: usize| digits.get(k).copied().unwrap_or(0);
            let places = (0..one.len().max(another.len())).rev();
            places
                .map(|k| digits(&one, k).cmp(&digits(&another, k)))
                .find(|order| order.is_ne())
                .unwrap_or(Ordering::Equal)
        })
    }
}

impl PartialOrd for Exact {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal numbers have equal digits once their exponents are.
    fn same(one: &Exact, other: &Exact) -> bool {
        one.cmp(other) == Ordering::Equal
    }

    fn whole(number: u64) -> Exact {
        Exact::whole(number)
    }

    #[test]
    fn small_numbers_add_multiply_and_compare_as_they_should() {
        let numbers = [0, 1, 2, 3, 7, 255, 1 << 31, (1 << 32) - 1, 1 << 32, (1 << 32) + 1, 3 << 40, (1 << 53) + 1];
        for (a, b) in numbers.iter().flat_map(|&a| numbers.iter().map(move |&b| (a, b))) {
            assert_eq!(whole(a).cmp(&whole(b)), a.cmp(&b));
            assert!(same(&whole(a).plus(&whole(b)), &whole(a + b)));
            assert_eq!(whole(a).plus(&whole(b)).floor(), Some(a + b));
            if let Some(product) = a.checked_mul(b) {
                assert_eq!(whole(a).times(&whole(b)).floor(), Some(product));
            }
            if a >= b {
                assert_eq!(whole(a).minus(&whole(b)).floor(), Some(a - b));
                assert!(same(&whole(a).minus(&whole(b)).plus(&whole(b)), &whole(a)));
            }
        }
    }

    #[test]
    fn every_float64_comes_back() {
        let most = f64::MAX;
        for number in [0.0, 5e-324, 2.2e-308, f64::MIN_POSITIVE, 0.1, 0.5, 1.0, 1.5, 1e15 + 0.5, 1e300, most] {
            assert_eq!(Exact::of(number).rounded_down(), number);
            let below = f64::from_bits(number.to_bits().saturating_sub(1));
            assert_eq!(Exact::of(number).cmp(&Exact::of(below)), number.total_cmp(&below));
        }
    }

    #[test]
    fn numbers_are_rounded_down_and_never_up() {
        let third = Exact::of(1.0 / 3.0);
        assert_eq!(third.plus(&Exact::of(5e-324)).rounded_down(), 1.0 / 3.0);
        assert_eq!(whole((1 << 53) + 1).rounded_down(), (1u64 << 53) as f64);
        assert_eq!(whole(u64::MAX).rounded_down(), 18446744073709549568.0);
        assert_eq!(Exact::of(f64::MAX).scaled(1).rounded_down(), f64::MAX);
        assert_eq!(Exact::of(5e-324).scaled(-1).rounded_down(), 0.0);
        assert_eq!(whole(3).scaled(-1075).rounded_down(), 5e-324);
    }

    #[test]
    fn floors_are_right_at_every_shift() {
        for shift in 0..80 {
            let number = 0x1234_5678_9abc_def1_u64;
            let exact = whole(number).scaled(-shift);
            assert_eq!(exact.floor(), Some(if shift < 64 { number >> shift } else { 0 }));
        }
        assert_eq!(whole(1).scaled(63).floor(), Some(1 << 63));
        assert_eq!(whole(1).scaled(64).floor(), None);
        assert_eq!(whole(3).scaled(63).floor(), None);
    }

    #[test]
    fn products_and_sums_lose_nothing_over_the_whole_range() {
        let (least, most) = (Exact::of(5e-324), Exact::of(f64::MAX));
        let sum = most.times(&most).plus(&least.times(&least));
        assert!(sum > most.times(&most));
        assert!(same(&sum.minus(&most.times(&most)), &whole(1).scaled(-2148)));
        // 2^106 - 2 * 2^53 + 1
        let odd = whole((1 << 53) - 1);
        let square = whole(1).scaled(106).plus(&whole(1)).minus(&whole(1).scaled(54));
        assert!(same(&odd.times(&odd), &square));
        assert!(same(&whole(0).times(&most), &whole(0)) && whole(0) < least);
    }
}
