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

    /// Adds so many samples at once.
    pub(crate) fn add_some(&mut self, id: u32, count: u16) {
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

/// How many samples of a pixel met what, by number: of all of them, so that it does not depend on their order.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct AllCounts(Vec<(u32, u16)>);

impl AllCounts {
    /// Adds so many samples.
    pub(crate) fn add(&mut self, id: u32, count: u16) {
        match self.0.binary_search_by_key(&id, |&(id, _)| id) {
            _ if id == u32::MAX => {}
            Ok(place) => self.0[place].1 = self.0[place].1.saturating_add(count),
            Err(place) => self.0.insert(place, (id, count)),
        }
    }

    /// Adds the samples of others.
    pub(crate) fn join(&mut self, others: &AllCounts) {
        others.0.iter().for_each(|&(id, count)| self.add(id, count));
    }

    /// Those that most samples met.
    pub(crate) fn most(mut self) -> IdCounts {
        self.0.sort_by_key(|&(id, count)| (std::cmp::Reverse(count), id));
        let mut most = IdCounts::NONE;
        self.0.iter().for_each(|&(id, count)| most.add_some(id, count));
        most
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

    #[test]
    fn counts_of_all_do_not_depend_on_order_and_the_most_are_kept() {
        let seen = [9, 3, 8, u32::MAX, 5, 7, 1, 9, 2, 2, 2];
        let counted = |ids: &[u32]| {
            let mut counts = AllCounts::default();
            ids.iter().for_each(|&id| counts.add(id, 1));
            counts
        };
        let (mut joined, all) = (counted(&seen[4..]), counted(&seen));
        joined.join(&counted(&seen[..4]));
        assert_eq!(joined, all);
        assert_eq!(all.most().iter().collect::<Vec<_>>(), [(2, 3), (9, 2), (1, 1), (3, 1), (5, 1), (7, 1)]);
    }
}
