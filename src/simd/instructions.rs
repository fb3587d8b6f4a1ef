//! What a processor does to sixteen lanes in one or two instructions, and compilers do not find by themselves: masks as bits,
//! and the moves behind [`super::Packing`].

/// With AVX-512. Rows are taken in halves of 32 bytes, as they are written where compilers prefer such vectors: a wider load
/// of what narrower stores have just left waits for them.
#[cfg(all(
    target_arch = "x86_64",
    target_feature = "avx512f",
    target_feature = "avx512vl",
    target_feature = "avx512dq"
))]
mod lanes {
    use std::arch::x86_64::*;

    const IOTA: [u32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

    /// One bit for each lane whose highest bit is set, that of lane 0 being the lowest.
    #[inline(always)]
    pub(crate) fn bits(lanes: &[u32; 16]) -> u16 {
        // SAFETY: the whole program is compiled for processors that have these instructions; both halves are read within the
        // array, without a demand on its alignment.
        unsafe {
            let (low, high) = (lanes.as_ptr(), lanes.as_ptr().add(8));
            let half = |lanes: *const u32| _mm256_movepi32_mask(_mm256_loadu_si256(lanes.cast()));
            half(low) as u16 | (half(high) as u16) << 8
        }
    }

    /// All bits of each lane whose bit in `mask` is set; none of the others.
    #[inline(always)]
    pub(crate) fn spread(mask: u16) -> [u32; 16] {
        let mut lanes = [0u32; 16];
        // SAFETY: as in `bits`; both halves are written within the array.
        unsafe {
            _mm256_storeu_si256(lanes.as_mut_ptr().cast(), _mm256_movm_epi32(mask as u8));
            _mm256_storeu_si256(lanes.as_mut_ptr().add(8).cast(), _mm256_movm_epi32((mask >> 8) as u8));
        }
        lanes
    }

    /// By lane: which lane of `chosen` goes there, where the first goes to lane `full` and what is beyond the last lane to the
    /// first.
    #[inline(always)]
    pub(crate) fn source(chosen: u16, full: usize) -> [u32; 16] {
        let mut source = [0u32; 16];
        // SAFETY: as in `bits`.
        unsafe {
            let iota = _mm512_loadu_si512(IOTA.as_ptr().cast());
            let packed = _mm512_maskz_compress_epi32(chosen, iota);
            // only the lower four bits of an index count
            let turned = _mm512_sub_epi32(iota, _mm512_set1_epi32(full as i32));
            _mm512_storeu_si512(source.as_mut_ptr().cast(), _mm512_permutexvar_epi32(turned, packed));
        }
        source
    }

    /// Puts `row[source[k]]` into lane k of `second`, and of `first` from lane `full` on. `T` has four bytes.
    #[inline(always)]
    pub(crate) fn put<T: Copy>(
        row: &[T; 16],
        source: &[u32; 16],
        full: usize,
        first: &mut [T; 16],
        second: &mut [T; 16],
    ) {
        const { assert!(size_of::<T>() == 4) };
        // SAFETY: as in `bits`; rows have 64 bytes, and are read and written within them.
        unsafe {
            let source = _mm512_loadu_si512(source.as_ptr().cast());
            let taken = _mm512_permutexvar_epi32(source, halves(row.as_ptr().cast()));
            _mm512_mask_storeu_epi32(first.as_mut_ptr().cast(), u16::MAX << full, taken);
            _mm512_storeu_si512(second.as_mut_ptr().cast(), taken);
        }
    }

    /// The same of eight bytes each.
    #[inline(always)]
    pub(crate) fn put_long(
        row: &[u64; 16],
        source: &[u32; 16],
        full: usize,
        first: &mut [u64; 16],
        second: &mut [u64; 16],
    ) {
        let keep = u16::MAX << full;
        // SAFETY: as in `bits`; rows have 128 bytes, and are read and written within them.
        unsafe {
            let (low, high) = (halves(row.as_ptr().cast()), halves(row.as_ptr().add(8).cast()));
            for half in 0..2 {
                let source = _mm256_loadu_si256(source.as_ptr().add(8 * half).cast());
                let taken = _mm512_permutex2var_epi64(low, _mm512_cvtepu32_epi64(source), high);
                _mm512_mask_storeu_epi64(first.as_mut_ptr().add(8 * half).cast(), (keep >> (8 * half)) as u8, taken);
                _mm512_storeu_si512(second.as_mut_ptr().add(8 * half).cast(), taken);
            }
        }
    }

    /// # Safety
    /// 64 bytes can be read from `row` on.
    #[inline(always)]
    unsafe fn halves(row: *const __m256i) -> __m512i {
        // SAFETY: as the caller says, and as in `bits`.
        unsafe {
            let low = _mm512_castsi256_si512(_mm256_loadu_si256(row));
            _mm512_inserti64x4::<1>(low, _mm256_loadu_si256(row.add(1)))
        }
    }
}

/// The same lane by lane.
#[cfg(not(all(
    target_arch = "x86_64",
    target_feature = "avx512f",
    target_feature = "avx512vl",
    target_feature = "avx512dq"
)))]
mod lanes {
    #[inline(always)]
    pub(crate) fn bits(lanes: &[u32; 16]) -> u16 {
        let mut bits = 0;
        for k in 0..16 {
            bits |= ((lanes[k] >> 31) as u16) << k;
        }
        bits
    }

    #[inline(always)]
    pub(crate) fn spread(mask: u16) -> [u32; 16] {
        let mut lanes = [0; 16];
        for k in 0..16 {
            lanes[k] = (mask as u32 >> k & 1).wrapping_neg();
        }
        lanes
    }

    #[inline(always)]
    pub(crate) fn source(chosen: u16, full: usize) -> [u32; 16] {
        let mut source = [0; 16];
        let (mut rest, mut lane) = (chosen, full);
        while rest != 0 {
            source[lane % 16] = rest.trailing_zeros();
            (rest, lane) = (rest & (rest - 1), lane + 1);
        }
        source
    }

    #[inline(always)]
    pub(crate) fn put<T: Copy>(
        row: &[T; 16],
        source: &[u32; 16],
        full: usize,
        first: &mut [T; 16],
        second: &mut [T; 16],
    ) {
        for lane in 0..16 {
            let taken = row[source[lane] as usize % 16];
            first[lane] = if lane < full { first[lane] } else { taken };
            second[lane] = taken;
        }
    }

    pub(crate) use put as put_long;
}

pub(crate) use lanes::{bits, spread};
pub(crate) use lanes::{put, put_long, source};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_are_bits_and_lanes() {
        for mask in [0, 1, 0x8000, 0xffff, 0b1010_0110_0000_0001, 0x7f80] {
            let lanes = spread(mask);
            assert_eq!(bits(&lanes), mask);
            assert!((0..16).all(|k| lanes[k] == if mask >> k & 1 == 1 { u32::MAX } else { 0 }));
        }
    }

    #[test]
    fn chosen_lanes_go_behind_those_that_are_there() {
        let row: [u32; 16] = std::array::from_fn(|k| 100 + k as u32);
        for full in 0..16 {
            for chosen in [0, 1, 0xffff, 0x8001, 0b0110_1001_1100_0011u16] {
                let (mut first, mut second) = ([7; 16], [8; 16]);
                put(&row, &source(chosen, full), full, &mut first, &mut second);
                let (mut long_first, mut long_second) = ([7; 16], [8; 16]);
                put_long(&row.map(u64::from), &source(chosen, full), full, &mut long_first, &mut long_second);
                assert_eq!((long_first, long_second), (first.map(u64::from), second.map(u64::from)));
                let filled: Vec<u32> = first[full..].iter().chain(&second).copied().collect();
                let expected: Vec<u32> = (0..16).filter(|k| chosen >> k & 1 == 1).map(|k| 100 + k).collect();
                assert_eq!(filled[..expected.len()], expected, "{chosen:b} behind {full}");
                assert!(first[..full].iter().all(|&lane| lane == 7), "what was there stays");
            }
        }
    }
}
