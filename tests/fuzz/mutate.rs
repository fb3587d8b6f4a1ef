//! How valid files are damaged. All of it is decided by a seed, so that an input can be made again.

/// SplitMix64 (Steele, Lea & Flood 2014).
pub struct Rng(u64);

impl Rng {
    pub fn new(seed: u64) -> Rng {
        Rng(seed)
    }

    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `n`, which is not 0.
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    pub fn pick<'a, T: ?Sized>(&mut self, from: &[&'a T]) -> &'a T {
        from[self.below(from.len())]
    }
}

/// No input grows beyond this.
const LONGEST: usize = 1 << 16;

/// Numbers at which sizes, counts and indices go wrong.
const EXTREMES: [u64; 24] = [
    0,
    1,
    2,
    7,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0x8000,
    0xffff,
    0x1_0000,
    0xff_ffff,
    0x0fff_ffff,
    0x3fff_ffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_fffe,
    0xffff_ffff,
    0x1_0000_0000,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_fff0,
    u64::MAX,
];

const NUMBERS: [&str; 40] = [
    "0",
    "-0",
    "1",
    "-1",
    "2",
    "0.5",
    "1e-45",
    "1e-30",
    "-1e-30",
    "1e30",
    "1e38",
    "3.5e38",
    "1e39",
    "-1e39",
    "1e308",
    "1e309",
    "1e-400",
    "nan",
    "-nan",
    "inf",
    "-inf",
    "+inf",
    "1.#INF",
    "-1.#IND",
    "127",
    "128",
    "255",
    "256",
    "65535",
    "65536",
    "65537",
    "2147483647",
    "2147483648",
    "-2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551615",
    "99999999999999999999999999999999999999999",
];

/// What is to be damaged: valid files of one kind and the words of its language.
pub struct Kind<'a> {
    pub seeds: &'a [Vec<u8>],
    pub words: &'a [&'a [u8]],
    /// Numbers and lines are what they look like.
    pub text: bool,
}

impl Kind<'_> {
    /// The `index`-th input: first the seeds as they are, then damaged ones.
    pub fn input(&self, index: u64) -> Vec<u8> {
        if let Some(seed) = self.seeds.get(index as usize) {
            return seed.clone();
        }
        let mut rng = Rng::new(index.wrapping_mul(0xd134_2543_de82_ef95));
        let mut bytes = self.seeds[rng.below(self.seeds.len())].clone();
        // mostly a single fault, at times a heap of them
        let faults = 1 + (rng.next().trailing_zeros() as usize).min(6);
        for _ in 0..faults * (1 + 7 * usize::from(rng.one_in(32))) {
            self.damage(&mut bytes, &mut rng);
        }
        bytes.truncate(LONGEST);
        bytes
    }

    fn damage(&self, bytes: &mut Vec<u8>, rng: &mut Rng) {
        match rng.below(if self.text { 18 } else { 12 }) {
            0 => flip(bytes, rng),
            1 => replace(bytes, rng.below(bytes.len() + 1), 1, &[rng.next() as u8]),
            2 | 3 => number(bytes, rng),
            4 => bytes.truncate(rng.below(bytes.len() + 1)),
            5 => {
                let (at, length) = part(bytes, rng);
                bytes.drain(at..at + length);
            }
            6 => double(bytes, rng),
            7 => {
                let noise: Vec<u8> = (0..rng.below(9)).map(|_| rng.next() as u8).collect();
                replace(bytes, rng.below(bytes.len() + 1), rng.below(9), &noise);
            }
            8 => self.splice(bytes, rng),
            9 | 10 => {
                let word = rng.pick(self.words);
                let instead = if rng.one_in(2) { word.len() } else { 0 };
                replace(bytes, rng.below(bytes.len() + 1), instead, word);
            }
            11 => {
                let (at, length) = part(bytes, rng);
                let value = rng.pick(&[&0u8, &0xff, &b' ', &b'\n']);
                bytes[at..at + length].fill(*value);
            }
            12..=14 => token(bytes, rng, |b| b.is_ascii_digit() || b"+-.".contains(&b), rng_number),
            15 => token(bytes, rng, |b| b.is_ascii_alphanumeric() || b == b'_', |rng| rng.pick(self.words).to_vec()),
            16 => line(bytes, rng),
            _ => deep(bytes, rng),
        }
    }

    /// The beginning of one file and the end of another.
    fn splice(&self, bytes: &mut Vec<u8>, rng: &mut Rng) {
        let other = &self.seeds[rng.below(self.seeds.len())];
        bytes.truncate(rng.below(bytes.len() + 1));
        bytes.extend(&other[rng.below(other.len() + 1)..]);
    }
}

fn rng_number(rng: &mut Rng) -> Vec<u8> {
    rng.pick(&NUMBERS).as_bytes().to_vec()
}

/// A part that is mostly short.
fn part(bytes: &[u8], rng: &mut Rng) -> (usize, usize) {
    let at = rng.below(bytes.len() + 1);
    let longest = if rng.one_in(4) { bytes.len() } else { 16 };
    (at, rng.below(longest + 1).min(bytes.len() - at))
}

fn replace(bytes: &mut Vec<u8>, at: usize, length: usize, with: &[u8]) {
    let end = (at + length).min(bytes.len());
    bytes.splice(at..end, with.iter().copied());
}

fn flip(bytes: &mut [u8], rng: &mut Rng) {
    if !bytes.is_empty() {
        let at = rng.below(bytes.len());
        bytes[at] ^= 1 << rng.below(8);
    }
}

/// An extreme number of one to eight bytes, or one next to what is there.
fn number(bytes: &mut [u8], rng: &mut Rng) {
    let width = [1, 2, 4, 4, 8][rng.below(5)];
    if bytes.len() < width {
        return;
    }
    let at = rng.below(bytes.len() - width + 1);
    let field = &mut bytes[at..at + width];
    let mut little = [0; 8];
    little[..width].copy_from_slice(field);
    let value = match rng.below(3) {
        0 => u64::from_le_bytes(little).wrapping_add(rng.below(33) as u64).wrapping_sub(16),
        _ => EXTREMES[rng.below(EXTREMES.len())],
    };
    field.copy_from_slice(&value.to_le_bytes()[..width]);
    if rng.one_in(2) {
        field.reverse();
    }
}

/// A part once more behind itself, at times often.
fn double(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let (at, length) = part(bytes, rng);
    let times = if rng.one_in(8) { 1 + rng.below(200) } else { 1 };
    let copies = bytes[at..at + length].repeat(times.min(LONGEST / length.max(1)));
    replace(bytes, at, 0, &copies);
}

/// Replaces one of the runs of bytes that `belongs` picks out.
fn token(bytes: &mut Vec<u8>, rng: &mut Rng, belongs: impl Fn(u8) -> bool, with: impl Fn(&mut Rng) -> Vec<u8>) {
    let from = rng.below(bytes.len() + 1);
    let Some(start) = (from..bytes.len()).find(|&i| belongs(bytes[i])) else { return };
    let start = (0..start).rev().take_while(|&i| belongs(bytes[i])).last().unwrap_or(start);
    let length = bytes[start..].iter().take_while(|&&b| belongs(b)).count();
    replace(bytes, start, length, &with(rng));
}

/// A line away, doubled or somewhere else.
fn line(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let from = rng.below(bytes.len() + 1);
    let start = bytes[..from].iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
    let end = bytes[start..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |i| start + i + 1);
    let whole = bytes[start..end].to_vec();
    match rng.below(3) {
        0 => drop(bytes.drain(start..end)),
        1 => replace(bytes, start, 0, &whole),
        _ => replace(bytes, rng.below(bytes.len() + 1), 0, &whole),
    }
}

/// Thousands of the same, which parsers that call themselves do not like.
fn deep(bytes: &mut Vec<u8>, rng: &mut Rng) {
    let unit =
        rng.pick(&[&b"["[..], b"{", b"[[", b"{\"a\":", b"a.", b"(", b"\\\n", b"a={", b" ", b"1", b"\"", b"/", b"-"]);
    let times = if rng.one_in(4) { 10_000 } else { 1 + rng.below(300) };
    replace(bytes, rng.below(bytes.len() + 1), 0, &unit.repeat(times));
}
