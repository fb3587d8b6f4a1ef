//! How much less the mean of samples varies that are spread evenly.
//!
//! The variance of the mean of n samples falls with n^−(1 + e): the evenness e is 0 where samples are independent, and up to 1
//! where the light is smooth over all that an even sequence covers. So the fewer samples cost as much as many others lose
//! twice, by their number and by how evenly so many lie.

/// The fewest samples of which halves say something of evenness: with four, the difference of halves is the same to first order
/// whatever it is.
const FEWEST: u32 = 8;

/// The evenness of `samples` samples by `ratio`: the variance of their mean as the difference of its halves tells it, over what it
/// were if they were independent. 0 of too few samples. Halves of an even sequence are such sequences, so that their difference says
/// 2^(1 + e) − 1 times the variance of the mean ([`crate::film::halves`]): the ratio is (2^(1 + e) − 1) n^−e.
pub fn evenness(ratio: f64, samples: u32) -> f64 {
    if samples < FEWEST || ratio.is_nan() {
        return 0.0;
    }
    let told = |e: f64| ((1.0 + e).exp2() - 1.0) * f64::from(samples).powf(-e);
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..f64::MANTISSA_DIGITS {
        let middle = 0.5 * (low + high);
        *(if told(middle) > ratio { &mut low } else { &mut high }) = middle;
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_evenness_of_a_power_law_is_found() {
        for samples in [8, 16, 47, 1000] {
            for expected in [0.0, 0.1, 0.25, 0.7] {
                let n = f64::from(samples);
                // (a − b)²/4 = (a² + b²)/2 − ((a + b)/2)²: what halves vary less what their mean does
                let variance = |n: f64| n.powf(-1.0 - expected);
                let ratio = (variance(n / 2.0) - variance(n)) / (1.0 / n);
                let found = evenness(ratio, samples);
                assert!((found - expected).abs() < 1e-9, "{samples} samples: {found} and not {expected}");
            }
        }
    }

    #[test]
    fn what_says_nothing_of_evenness_has_none() {
        assert_eq!([evenness(0.5, 4), evenness(f64::NAN, 64), evenness(1.3, 64)], [0.0; 3]);
    }
}
