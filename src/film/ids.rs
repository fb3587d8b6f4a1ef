//! What is seen in a pixel, by number, and how much of it.

/// What is counted: objects and materials.
pub(crate) const KINDS: usize = 2;

/// Numbers of what a camera ray meets, by kind.
pub(crate) type Ids = [u32; KINDS];

/// The number of nothing.
pub(crate) const NOTHING: Ids = [u32::MAX; KINDS];

/// How many different ones a pixel keeps: the ranks of Cryptomatte's first three layers.
pub(crate) const RANKS: usize = 6;

/// How many samples of a pixel met what. Of more than [`RANKS`], those that come last are dropped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct IdCounts {
    ids: [u32; RANKS],
    counts: [u16; RANKS],
}

impl IdCounts {
    pub(crate) const NONE: IdCounts = IdCounts { ids: [u32::MAX; RANKS], counts: [0; RANKS] };

    /// Adds a sample.
    pub(crate) fn add(&mut self, id: u32) {
        self.add_some(id, 1);
    }

    /// Adds the samples of others.
    pub(crate) fn join(&mut self, others: &IdCounts) {
        others.iter().for_each(|(id, count)| self.add_some(id, count));
    }

    fn add_some(&mut self, id: u32, count: u16) {
        let place = (0..RANKS).find(|&k| self.counts[k] == 0 || self.ids[k] == id);
        if let Some(k) = place.filter(|_| id != u32::MAX) {
            self.ids[k] = id;
            self.counts[k] = self.counts[k].saturating_add(count);
        }
    }

    /// Numbers with their counts, in the order in which they came.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (u32, u16)> {
        self.ids.into_iter().zip(self.counts).take_while(|(_, count)| *count > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_counted_by_what_they_met() {
        let mut counts = IdCounts::NONE;
        [3, 5, u32::MAX, 3, 7].into_iter().for_each(|id| counts.add(id));
        assert_eq!(counts.iter().collect::<Vec<_>>(), [(3, 2), (5, 1), (7, 1)]);
        (10..20).for_each(|id| counts.add(id));
        assert_eq!(counts.iter().map(|(id, _)| id).collect::<Vec<_>>(), [3, 5, 7, 10, 11, 12], "six are kept");
        let mut others = IdCounts::NONE;
        [12, 8, 5, 5].into_iter().for_each(|id| others.add(id));
        others.join(&counts);
        assert_eq!(others.iter().collect::<Vec<_>>(), [(12, 2), (8, 1), (5, 3), (3, 2), (7, 1), (10, 1)]);
    }
}
