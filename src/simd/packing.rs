//! Packing: the chosen lanes of one packet are appended, without gaps, to a sequence of packets.

use super::{LANES, instructions};

/// Where the chosen lanes of a packet go: into a packet that may be partly full, and on into the one behind it. Found once,
/// it serves every row of numbers that those lanes carry.
pub(crate) struct Packing {
    /// By lane of the packets that are filled: the lane that goes there.
    source: [u32; LANES],
    /// Lanes of the first packet that are full already.
    full: usize,
    /// Place of the first packet.
    packet: usize,
    count: usize,
}

impl Packing {
    /// Takes the lanes whose bit in `chosen` is set, in their order, behind `len` lanes that are there already.
    #[inline(always)]
    pub(crate) fn new(chosen: u16, len: usize) -> Packing {
        let full = len % LANES;
        let source = instructions::source(chosen, full);
        Packing { source, full, packet: len / LANES, count: chosen.count_ones() as usize }
    }

    /// How many lanes were chosen.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// The two packets that are filled, made where they are not there yet.
    #[inline(always)]
    pub(crate) fn packets<'a, P>(&self, packets: &'a mut Vec<P>, empty: impl Fn() -> P) -> [&'a mut P; 2] {
        while packets.len() < self.packet + 2 {
            packets.push(empty());
        }
        packets[self.packet..].first_chunk_mut::<2>().expect("there are two").each_mut()
    }

    /// Puts the chosen numbers of a row into the same row of both packets. Other lanes of the second are unspecified.
    #[inline(always)]
    pub(crate) fn put<T: Number>(&self, row: &[T; LANES], [first, second]: [&mut [T; LANES]; 2]) {
        T::put(row, &self.source, self.full, first, second);
    }
}

mod private {
    pub(crate) trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for u32 {}
    impl Sealed for u64 {}
}

/// What rows are made of.
pub(crate) trait Number: Copy + private::Sealed {
    #[doc(hidden)]
    fn put(row: &[Self; 16], source: &[u32; 16], full: usize, first: &mut [Self; 16], second: &mut [Self; 16]);
}

macro_rules! number {
    ($number:ty, $put:ident) => {
        impl Number for $number {
            #[inline(always)]
            fn put(row: &[Self; 16], source: &[u32; 16], full: usize, first: &mut [Self; 16], second: &mut [Self; 16]) {
                instructions::$put(row, source, full, first, second);
            }
        }
    };
}

number!(f32, put);
number!(u32, put);
number!(u64, put_long);
