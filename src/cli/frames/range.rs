//! Which frames are rendered.

use std::str::FromStr;

/// The largest number of a frame.
const LAST: u32 = 999_999;

/// From the first to the last, both rendered if they are whole steps apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct FrameRange {
    first: u32,
    last: u32,
    step: u32,
}

impl FrameRange {
    pub(super) fn numbers(self) -> impl ExactSizeIterator<Item = u32> + Clone {
        let FrameRange { first, last, step } = self;
        (0..=(last - first) / step).collect::<Vec<_>>().into_iter().map(move |k| first + k * step)
    }

    pub(crate) fn first(self) -> u32 {
        self.first
    }
}

impl FromStr for FrameRange {
    type Err = String;

    /// `A..B`, `A..B:STEP` or `A`.
    fn from_str(text: &str) -> Result<FrameRange, String> {
        let wrong = || format!("expected frames as 1..240, 1..240:2 or 7, from 0 to {LAST}, and found `{text}`");
        let number = |text: &str| text.parse().ok().filter(|n| *n <= LAST).ok_or_else(wrong);
        let (range, step) = text.split_once(':').map_or((text, "1"), |(range, step)| (range, step));
        let (first, last) = range.split_once("..").unwrap_or((range, range));
        let (first, last, step) = (number(first)?, number(last)?, number(step)?);
        if first > last || step == 0 { Err(wrong()) } else { Ok(FrameRange { first, last, step }) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_have_their_ends_and_steps() {
        let numbers = |text: &str| text.parse::<FrameRange>().map(|range| range.numbers().collect::<Vec<_>>());
        assert_eq!(numbers("3..6"), Ok(vec![3, 4, 5, 6]));
        assert_eq!(numbers("1..10:4"), Ok(vec![1, 5, 9]));
        assert_eq!(numbers("7"), Ok(vec![7]));
        for wrong in ["", "5..4", "1..5:0", "1...5", "-1..3", "1..1000000", "a", "1..2:x"] {
            assert!(numbers(wrong).is_err(), "{wrong}");
        }
    }
}
