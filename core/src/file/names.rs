//! Names in words: byte offsets, one more than names, counted from the end of the offsets; then the UTF-8 bytes, four a
//! word, low byte first, padded with 0. A `&str` cannot be borrowed from words of either byte order, so a [`Name`] is a
//! view that prints itself.

use super::error::LoadError;
use core::fmt::{self, Write};

/// The checked section.
#[derive(Clone, Copy, Debug)]
pub(super) struct Names<'a> {
    offsets: &'a [u32],
    text: &'a [u32],
}

/// The name of a material; `Display` gives the text, and it compares with `str`.
#[derive(Clone, Copy)]
pub struct Name<'a> {
    text: &'a [u32],
    start: usize,
    end: usize,
}

impl<'a> Names<'a> {
    /// Checks that there are `count` names, all of them UTF-8, and nothing else.
    pub(super) fn new(words: &'a [u32], count: usize) -> Result<Names<'a>, LoadError> {
        let expected = count as u64 + 1;
        let Some((offsets, text)) = words.split_at_checked(count + 1) else {
            return Err(LoadError::Names { expected, found: words.len() as u64 });
        };
        let end = u64::from(offsets[count]);
        if end.div_ceil(4) != text.len() as u64 {
            return Err(LoadError::Names { expected: expected + end.div_ceil(4), found: words.len() as u64 });
        }
        let names = Names { offsets, text };
        for index in 0..count {
            let in_order = offsets[index] <= offsets[index + 1] && u64::from(offsets[index + 1]) <= end;
            if !in_order || (index == 0 && offsets[0] != 0) || names.get(index).chars().any(|c| c.is_none()) {
                return Err(LoadError::Name { index: index as u32 });
            }
        }
        let padding = Name { text, start: end as usize, end: 4 * text.len() };
        if padding.bytes().any(|byte| byte != 0) {
            return Err(LoadError::Name { index: count as u32 });
        }
        Ok(names)
    }

    /// The name at `index`; empty beyond the last.
    pub(super) fn get(&self, index: usize) -> Name<'a> {
        match self.offsets.get(index..).and_then(|rest| rest.first_chunk()) {
            Some(&[start, end]) => Name { text: self.text, start: start as usize, end: end as usize },
            None => Name { text: &[], start: 0, end: 0 },
        }
    }
}

impl<'a> Name<'a> {
    /// The UTF-8 bytes.
    pub fn bytes(self) -> impl Iterator<Item = u8> + 'a {
        (self.start..self.end).map_while(move |at| Some(self.text.get(at / 4)?.to_le_bytes()[at % 4]))
    }

    /// Whether the name has no character.
    pub fn is_empty(&self) -> bool {
        self.start == self.end
    }

    /// The characters; `None` once where the bytes are no UTF-8, which ends them.
    fn chars(self) -> impl Iterator<Item = Option<char>> + 'a {
        let mut bytes = self.bytes();
        let mut valid = true;
        core::iter::from_fn(move || {
            let first = bytes.next().filter(|_| valid)?;
            let length = match first {
                0..0x80 => 1,
                0x80..0xe0 => 2,
                0xe0..0xf0 => 3,
                _ => 4,
            };
            let mut buffer = [first, 0, 0, 0];
            let read = 1 + buffer[1..length].iter_mut().zip(&mut bytes).map(|(to, byte)| *to = byte).count();
            let char = core::str::from_utf8(&buffer[..read]).ok().and_then(|text| text.chars().next());
            valid = char.is_some();
            Some(char)
        })
    }
}

impl fmt::Display for Name<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.chars().flatten().try_for_each(|c| f.write_char(c))
    }
}

impl fmt::Debug for Name<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"")?;
        self.chars().flatten().flat_map(char::escape_debug).try_for_each(|c| f.write_char(c))?;
        write!(f, "\"")
    }
}

impl PartialEq<str> for Name<'_> {
    fn eq(&self, other: &str) -> bool {
        self.bytes().eq(other.bytes())
    }
}

impl PartialEq<&str> for Name<'_> {
    fn eq(&self, other: &&str) -> bool {
        *self == **other
    }
}
