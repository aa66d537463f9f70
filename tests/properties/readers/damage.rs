//! Bytes at random, and files with damage at random places.

/// Pieces that mean something to some reader.
const TELLING: [&[u8]; 24] = [
    b"\"",
    b"'",
    b"[",
    b"]",
    b"{",
    b"}",
    b"=",
    b".",
    b",",
    b"-",
    b"+",
    b"/",
    b"\\",
    b"#",
    b"(",
    b"\r",
    b"\n",
    b"\t",
    b"\0",
    b"\xff",
    b"\x80",
    b"'''",
    b"\x7f",
    "é\u{202e}".as_bytes(),
];
/// Numbers beyond what files hold.
const NUMBERS: [&[u8]; 12] = [
    b"0",
    b"-1",
    b"2",
    b"nan",
    b"-inf",
    b"1e-300",
    b"-1e308",
    b"1e13",
    b"1e7",
    b"65536",
    b"4294967296",
    b"18446744073709551616",
];

/// Knuth's 64-bit linear congruential generator, so that every run draws the same.
pub struct Lcg(pub u64);

impl Lcg {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as usize) % n.max(1)
    }

    fn byte(&mut self) -> u8 {
        self.below(256) as u8
    }
}

/// Bytes without any order.
pub fn noise(random: &mut Lcg) -> Vec<u8> {
    let length = random.below(200);
    (0..length).map(|_| random.byte()).collect()
}

/// Some places overwritten, deleted, doubled, filled with what means something or with numbers beyond all bounds; at
/// times cut off.
pub fn damaged(bytes: &[u8], random: &mut Lcg) -> Vec<u8> {
    let mut damaged = bytes.to_vec();
    for _ in 0..=random.below(3) {
        let at = random.below(damaged.len());
        let end = (at + random.below(12)).min(damaged.len());
        match random.below(16) {
            0 => damaged.truncate(at),
            1..=3 => drop(damaged.drain(at..end)),
            4 | 5 => {
                let piece = damaged[at..end].to_vec();
                let to = random.below(damaged.len());
                damaged.splice(to..to, piece);
            }
            6 => damaged.insert(at, random.byte()),
            7..=9 => {
                let end = if random.below(2) == 0 { at } else { end };
                damaged.splice(at..end, TELLING[random.below(TELLING.len())].iter().copied());
            }
            10 | 11 => {
                let number = number_at(&damaged, at);
                damaged.splice(number, NUMBERS[random.below(NUMBERS.len())].iter().copied());
            }
            12 | 13 => overwrite(&mut damaged, at, b'0' + random.below(10) as u8),
            _ => overwrite(&mut damaged, at, random.byte()),
        }
    }
    damaged
}

fn overwrite(bytes: &mut [u8], at: usize, byte: u8) {
    if let Some(slot) = bytes.get_mut(at) {
        *slot = byte;
    }
}

/// Where the first number at or behind a place stands.
fn number_at(bytes: &[u8], at: usize) -> std::ops::Range<usize> {
    let is_part = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-');
    let start = bytes[at..].iter().position(is_part).map_or(bytes.len(), |skipped| at + skipped);
    let length = bytes[start..].iter().position(|b| !is_part(b)).unwrap_or(bytes.len() - start);
    start..start + length
}
