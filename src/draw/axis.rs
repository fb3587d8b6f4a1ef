//! Axes: which part of the numbers is shown, and which of them are marked.

/// A line of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    logarithmic: bool,
}

impl Axis {
    /// Around positive values, with a margin; at least a factor of three is seen. `None` without values.
    pub(crate) fn logarithmic(values: impl Iterator<Item = f64>) -> Option<Axis> {
        let (low, high) = range(values.filter(|v| *v > 0.0))?;
        let margin = 1.12f64.max((3.0 * low / high).sqrt());
        Some(Axis { low: low / margin, high: high * margin, logarithmic: true })
    }

    /// Around values, with a margin; at least a tenth of the largest is seen. `None` without values.
    pub(crate) fn linear(values: impl Iterator<Item = f64>) -> Option<Axis> {
        let (low, high) = range(values)?;
        let size = low.abs().max(high.abs());
        let margin = (0.06 * (high - low)).max(0.5 * (0.1 * size - (high - low))).max(1e-12);
        Some(Axis { low: low - margin, high: high + margin, logarithmic: false })
    }

    /// From 0 to a little above the largest of the values; `None` where that is not positive.
    pub(crate) fn from_zero(values: impl Iterator<Item = f64>) -> Option<Axis> {
        let (_, high) = range(values).filter(|(_, high)| *high > 0.0)?;
        Some(Axis { low: 0.0, high: 1.03 * high, logarithmic: false })
    }

    /// 0 at the lower end, 1 at the upper; within, whatever the value.
    pub(crate) fn place(&self, value: f64) -> f64 {
        let map = |x: f64| if self.logarithmic { x.max(f64::MIN_POSITIVE).ln() } else { x };
        ((map(value) - map(self.low)) / (map(self.high) - map(self.low))).clamp(0.0, 1.0)
    }

    /// Whether the value lies between the ends.
    pub(crate) fn shows(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Numbers to mark, about four to eight of them, and how they are written.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        let values = if self.logarithmic { self.powers() } else { self.steps() };
        values.into_iter().map(|v| (v, written(v))).collect()
    }

    fn powers(&self) -> Vec<f64> {
        let decades = (self.high / self.low).log10();
        let (every, multiples): (i32, &[f64]) = match decades {
            d if d > 12.0 => (4, &[1.0]),
            d if d > 6.0 => (2, &[1.0]),
            d if d > 2.5 => (1, &[1.0]),
            d if d > 1.2 => (1, &[1.0, 3.0]),
            d if d > 0.7 => (1, &[1.0, 2.0, 5.0]),
            _ => (1, &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0]),
        };
        let exponents = (self.low.log10().floor() as i32)..=(self.high.log10().ceil() as i32);
        let power = |e: i32| multiples.iter().map(move |m| if e < 0 { m / 10f64.powi(-e) } else { m * 10f64.powi(e) });
        let all = exponents.filter(|e| e.rem_euclid(every) == 0).flat_map(power);
        all.filter(|v| (self.low..=self.high).contains(v)).collect()
    }

    fn steps(&self) -> Vec<f64> {
        let rough = (self.high - self.low) / 6.0;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough).unwrap_or(10.0 * power);
        let first = (self.low / step).ceil() as i64;
        // division by a whole number keeps what is written short
        let value = |k: i64| if step < 1.0 { k as f64 / (1.0 / step).round() } else { k as f64 * step };
        (first..first + 12).map(value).filter(|v| *v <= self.high).collect()
    }
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let add = |r: Option<(f64, f64)>, v: f64| Some(r.map_or((v, v), |(a, b)| (a.min(v), b.max(v))));
    values.filter(|v| v.is_finite()).fold(None, add)
}

/// A number in few characters.
pub(crate) fn written(value: f64) -> String {
    let size = value.abs();
    if value != 0.0 && !(1e-3..1e5).contains(&size) { format!("{value:e}") } else { value.to_string() }
}

/// To three digits.
pub(crate) fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let size = value.abs().log10().floor() as i32;
    match size {
        3..=5 => format!("{value:.0}"),
        -3..=2 => format!("{value:.*}", (2 - size) as usize),
        _ => format!("{value:.2e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written_ticks(axis: Option<Axis>) -> Vec<String> {
        axis.unwrap().ticks().into_iter().map(|t| t.1).collect()
    }

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(written_ticks(Axis::logarithmic([1e-4, 1.0].into_iter())), ["1e-4", "0.001", "0.01", "0.1", "1"]);
        assert_eq!(written_ticks(Axis::logarithmic([5.0, 20.0].into_iter())), ["5", "10", "20"]);
        assert_eq!(written_ticks(Axis::logarithmic([4.0].into_iter())), ["3", "4", "5"]);
        assert_eq!(written_ticks(Axis::linear([3.0, 6.1].into_iter())), ["3", "4", "5", "6"]);
        assert_eq!(written_ticks(Axis::linear([0.11, 0.13].into_iter())), ["0.11", "0.115", "0.12", "0.125", "0.13"]);
        for high in [1.001, 1.3, 2.0, 7.0, 40.0, 1e3, 1e6, 1e9, 1e20] {
            let n = Axis::logarithmic([1.0, high].into_iter()).unwrap().ticks().len();
            assert!((2..=8).contains(&n), "{n} ticks up to {high}");
            let n = Axis::linear([1.0, high].into_iter()).unwrap().ticks().len();
            assert!((2..=8).contains(&n), "{n} steps up to {high}");
        }
    }

    #[test]
    fn places_go_from_end_to_end() {
        let axis = Axis::logarithmic([1.0, 100.0].into_iter()).unwrap();
        assert!((axis.place(10.0) - 0.5).abs() < 1e-12);
        assert!(axis.place(1.0) > 0.0 && axis.place(100.0) < 1.0);
        assert_eq!((axis.place(-1.0), axis.place(1e9)), (0.0, 1.0));
        assert!(axis.shows(1.0) && axis.shows(100.0) && !axis.shows(-1.0) && !axis.shows(1e9));
        assert_eq!(Axis::logarithmic([0.0, -1.0, f64::NAN].into_iter()), None);
        assert_eq!(Axis::linear([0.0].into_iter()).unwrap().place(0.0), 0.5);
    }

    #[test]
    fn numbers_have_three_digits() {
        let cases = [(1.2345, "1.23"), (123.45, "123"), (0.012345, "0.0123"), (12345.0, "12345"), (1e-5, "1.00e-5")];
        cases.iter().for_each(|(value, text)| assert_eq!(short(*value), *text));
        assert_eq!(short(0.0), "0");
    }
}
