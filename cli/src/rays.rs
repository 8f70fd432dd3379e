//! Rays as text: one a line, `ox,oy,oz,dx,dy,dz[,tmin,tmax]`, decimal or C99 hexadecimal.
//!
//! In: a stream of bytes. Out: blocks of whole lines, a bounded number of bytes at a time, and the ray of a line or what
//! is wrong with it. A block holds what one read gave, so a program that waits for its answers gets them. Blank lines
//! are skipped, lines may end with CRLF, and the first may name the columns.

use std::io::{ErrorKind, Read};

use crate::hexfloat::{self, HexFloatError};

/// Most bytes of a block, and so of a line.
const BLOCK: usize = 4 << 20;

/// A ray as it is typed.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Ray {
    pub origin: [f64; 3],
    pub dir: [f64; 3],
    pub t_min: f64,
    pub t_max: f64,
}

/// Whole lines of a stream, block by block.
pub struct Blocks<R> {
    reader: R,
    bytes: Vec<u8>,
    /// Bytes that were read and are still there.
    filled: usize,
    /// Bytes of the block that was handed out; what follows is the begun line.
    taken: usize,
    ended: bool,
}

impl<R: Read> Blocks<R> {
    /// From the start of a stream.
    pub fn new(reader: R) -> Blocks<R> {
        Blocks { reader, bytes: vec![0; BLOCK], filled: 0, taken: 0, ended: false }
    }

    /// The next lines; the last of a stream may lack its end. `None` after the last. A line that fills a block is cut.
    pub fn next(&mut self) -> std::io::Result<Option<&[u8]>> {
        self.bytes.copy_within(self.taken..self.filled, 0);
        self.filled -= self.taken;
        while !self.ended && self.filled < BLOCK {
            let read = match self.reader.read(&mut self.bytes[self.filled..]) {
                Err(e) if e.kind() == ErrorKind::Interrupted => continue,
                read => read?,
            };
            self.ended = read == 0;
            // What was left over holds no end of line.
            let new = &self.bytes[self.filled..][..read];
            let end = new.iter().rposition(|&b| b == b'\n').map(|at| self.filled + at + 1);
            self.filled += read;
            if let Some(end) = end {
                self.taken = end;
                return Ok(Some(&self.bytes[..end]));
            }
        }
        self.taken = self.filled;
        Ok((self.taken > 0).then_some(&self.bytes[..self.taken]))
    }
}

/// The lines of a block, without their ends.
pub fn lines(block: &[u8]) -> impl Iterator<Item = &[u8]> {
    block.split_inclusive(|&b| b == b'\n').map(|line| line.strip_suffix(b"\n").unwrap_or(line))
}

/// The block in pieces of whole lines of about `size` bytes.
pub fn pieces(block: &[u8], size: usize) -> Vec<&[u8]> {
    let (mut pieces, mut rest) = (Vec::new(), block);
    while !rest.is_empty() {
        let from = size.min(rest.len());
        let end = rest[from..].iter().position(|&b| b == b'\n').map_or(rest.len(), |at| from + at + 1);
        let (piece, more) = rest.split_at(end);
        pieces.push(piece);
        rest = more;
    }
    pieces
}

/// Whether a line names the columns: it has text, and no field of it is a number.
pub fn is_header(line: &[u8]) -> bool {
    std::str::from_utf8(line).is_ok_and(|text| text.split(',').all(|field| number(field).is_err()))
}

/// Whether a line says nothing.
pub fn is_blank(line: &[u8]) -> bool {
    line.trim_ascii().is_empty()
}

/// The ray of a line, or what is wrong with it.
pub fn ray(line: &[u8]) -> Result<Ray, String> {
    const EXPECTED: &str = "expected ox,oy,oz,dx,dy,dz or ox,oy,oz,dx,dy,dz,tmin,tmax";
    if line.len() >= BLOCK {
        return Err(format!("the line is longer than {BLOCK} bytes: {EXPECTED}"));
    }
    let text = std::str::from_utf8(line).map_err(|_| format!("the line is no text: {EXPECTED}"))?;
    let mut numbers = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, f64::INFINITY];
    let mut found = 0;
    for field in text.split(',') {
        if let Some(number_at) = numbers.get_mut(found) {
            // A spreadsheet pads short rows: an empty limit is none.
            if found < 6 || !field.trim_ascii().is_empty() {
                *number_at = number(field)?;
            }
        }
        found += 1;
    }
    if found != 6 && found != 8 {
        return Err(format!("{found} fields: {EXPECTED}"));
    }
    let [ox, oy, oz, dx, dy, dz, t_min, t_max] = numbers;
    Ok(Ray { origin: [ox, oy, oz], dir: [dx, dy, dz], t_min, t_max })
}

/// A field's number. `inf` and `nan` are numbers; what is written with digits and does not fit is none.
fn number(field: &str) -> Result<f64, String> {
    const LONGEST: usize = 40;
    let text = field.trim_ascii();
    let shown = || match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("`{}...`", &text[..end]),
        None => format!("`{text}`"),
    };
    let too_large = || format!("{} is too large: expected at most 1.797e308", shown());
    let no_number = || format!("{} is not a number: expected one such as -1.5e3 or 0x1.8p3", shown());
    if hexfloat::is_hex(text) {
        return hexfloat::parse(text).map_err(|error| match error {
            HexFloatError::Overflow => too_large(),
            HexFloatError::Syntax => no_number(),
        });
    }
    match text.parse::<f64>() {
        Ok(x) if x.is_infinite() && text.contains(|c: char| c.is_ascii_digit()) => Err(too_large()),
        Ok(x) => Ok(x),
        Err(_) => Err(no_number()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives at most three bytes at a time.
    struct Drip<'a>(&'a [u8]);

    impl Read for Drip<'_> {
        fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
            let mut some = &self.0[..self.0.len().min(3)];
            let read = some.read(out)?;
            self.0 = &self.0[read..];
            Ok(read)
        }
    }

    #[test]
    fn blocks_are_whole_lines_however_they_arrive() {
        for text in ["", "\n", "a", "a\nbcdefghi\n\nj", "abcdefgh\r\nijk\n"] {
            let mut blocks = Blocks::new(Drip(text.as_bytes()));
            let mut found = Vec::new();
            while let Some(block) = blocks.next().unwrap() {
                assert!(block.ends_with(b"\n") || text.as_bytes().ends_with(block));
                found.extend(lines(block).map(<[u8]>::to_vec));
            }
            let expected: Vec<_> = lines(text.as_bytes()).map(<[u8]>::to_vec).collect();
            assert_eq!(found, expected, "{text:?}");
            assert_eq!(pieces(text.as_bytes(), 4).concat(), text.as_bytes());
        }
        assert_eq!(pieces(b"ab\ncdefg\nh\n", 1), [&b"ab\n"[..], b"cdefg\n", b"h\n"]);
    }

    #[test]
    fn a_line_without_end_is_cut() {
        let mut blocks = Blocks::new(std::io::repeat(b'7'));
        assert_eq!(blocks.next().unwrap().map(<[u8]>::len), Some(BLOCK));
        assert!(ray(&vec![b'7'; BLOCK]).is_err());
    }

    #[test]
    fn rays_and_what_is_none() {
        let plain = ray(b" 1, -2.5,0x1.8p3 ,0,0,1e-3\r").unwrap();
        assert_eq!((plain.origin, plain.dir), ([1.0, -2.5, 12.0], [0.0, 0.0, 1e-3]));
        assert_eq!((plain.t_min, plain.t_max), (0.0, f64::INFINITY));
        assert_eq!(ray(b"1,-2.5,12,0,0,0.001,,"), Ok(plain));
        let bounded = ray(b"0,0,0,0,0,1,-inf,7").unwrap();
        assert_eq!((bounded.t_min, bounded.t_max), (f64::NEG_INFINITY, 7.0));
        for (line, words) in [
            ("1,2,3,4,5", "5 fields"),
            ("1,2,3,4,5,6,7", "7 fields"),
            ("1,2,3,4,5,6,7,8,9", "9 fields"),
            ("1,2,x,4,5,6", "`x` is not a number"),
            ("1,2,,4,5,6", "`` is not a number"),
            ("1,2,0x,4,5,6", "`0x` is not a number"),
            ("1e999,2,3,4,5,6", "`1e999` is too large"),
            ("0x1p1024,2,3,4,5,6", "`0x1p1024` is too large"),
        ] {
            let error = ray(line.as_bytes()).unwrap_err();
            assert!(error.contains(words) && error.contains("expected"), "{line}: {error}");
        }
        assert!(is_header(b"ox,oy,oz,dx,dy,dz\r") && is_header(b"origin x;y") && !is_header(b"a,2,c"));
    }
}
