//! What OBJ and MTL files have in common: bytes become text, text becomes numbered statements, and whatever is to be
//! said about a file is said with its line.
//!
//! In: any bytes. Out: never a refusal. UTF-8 and UTF-16 (by their marks) are decoded; any other byte that is not UTF-8
//! is read as Latin-1. Lines end at CR LF, LF or a lone CR; a `\` at the end joins the next line with a space between,
//! except in comments, where it is the end of some Windows path. A statement bears the number of its first line.

use alloc::borrow::Cow;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;

/// What is to be said about a line of a file: a warning, or the content of an error.
///
/// Shown as `LINE: MESSAGE` for the OBJ and as `FILE:LINE: MESSAGE` for an MTL, so that a caller who knows the path of
/// the OBJ puts it and a colon in front of the former.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Note {
    /// Path of the MTL as the OBJ names it (with `/` between folders); empty for the OBJ itself.
    pub file: String,
    /// Line, counted from 1, in the file as it is.
    pub line: u32,
    /// What was found, what was expected, what follows from it or what to do.
    pub message: String,
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.file.is_empty() {
            write!(f, "{}:", self.file)?;
        }
        write!(f, "{}: {}", self.line, self.message)
    }
}

/// Warnings in the order they were met. Their number is bounded, so that memory stays in proportion to the input even
/// where one file is named as a library thousands of times.
#[derive(Default)]
pub(crate) struct Notes {
    list: Vec<Note>,
    left_out: usize,
}

/// Warnings that are kept.
const MOST_NOTES: usize = 1000;

impl Notes {
    pub(crate) fn push(&mut self, file: &str, line: u32, message: String) {
        if self.list.len() < MOST_NOTES {
            self.list.push(Note { file: file.into(), line, message });
        } else {
            self.left_out += 1;
        }
    }

    pub(crate) fn into_list(mut self) -> Vec<Note> {
        if let (Some(last), true) = (self.list.last_mut(), self.left_out > 0) {
            last.message = format!("{}; {} more warnings are left out", last.message, self.left_out);
        }
        self.list
    }
}

/// A piece of a file as a message shows it: in quotes, control characters escaped, at most 40 characters.
pub(crate) fn quote(piece: &str) -> String {
    match piece.char_indices().nth(40) {
        Some((end, _)) => format!("{:?}...", &piece[..end]),
        None => format!("{piece:?}"),
    }
}

/// A path as files write it: without quotes around it, with `/` between folders.
pub(crate) fn path(written: &str) -> String {
    let bare = written.trim();
    let bare = bare.strip_prefix('"').and_then(|rest| rest.strip_suffix('"')).unwrap_or(bare);
    let slashes = bare.replace('\\', "/");
    // One spelling per file: no empty segments, and none that stay where they are.
    let root = if slashes.starts_with('/') { "/" } else { "" };
    let parts: Vec<&str> = slashes.split('/').filter(|part| !matches!(*part, "" | ".")).collect();
    format!("{root}{}", parts.join("/"))
}

/// The bytes of a file as text.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let utf16 = |rest: &[u8], unit: fn([u8; 2]) -> u16| -> Cow<'static, str> {
        let units = rest.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => return utf16(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return utf16(rest, u16::from_be_bytes),
        _ => {}
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => {
            let mut text = String::with_capacity(bytes.len() + bytes.len() / 8);
            for chunk in bytes.utf8_chunks() {
                text.push_str(chunk.valid());
                text.extend(chunk.invalid().iter().map(|&byte| char::from(byte)));
            }
            Cow::Owned(text)
        }
    }
}

/// The statements of a text, trimmed, with the number of the line each begins on.
pub(crate) struct Statements<'a> {
    rest: &'a str,
    line: u32,
}

/// Splits a text into statements; empty lines and comments come out too, the latter from their `#` on.
pub(crate) fn statements(text: &str) -> Statements<'_> {
    Statements { rest: text, line: 0 }
}

impl<'a> Statements<'a> {
    fn physical_line(&mut self) -> Option<&'a str> {
        if self.rest.is_empty() {
            return None;
        }
        self.line = self.line.saturating_add(1);
        let bytes = self.rest.as_bytes();
        let end = bytes.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(bytes.len());
        let line = &self.rest[..end];
        let ending = if bytes[end..].starts_with(b"\r\n") { 2 } else { 1 };
        self.rest = self.rest.get(end + ending..).unwrap_or("");
        Some(line.trim())
    }
}

impl<'a> Iterator for Statements<'a> {
    type Item = (u32, Cow<'a, str>);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let first = self.physical_line()?;
        let number = self.line;
        let Some(mut part) = continued(first) else { return Some((number, Cow::Borrowed(first))) };
        let mut joined = String::new();
        loop {
            joined.push_str(part);
            if !joined.is_empty() {
                joined.push(' ');
            }
            let Some(line) = self.physical_line() else { break };
            let Some(next) = continued(line) else {
                joined.push_str(line);
                break;
            };
            part = next;
        }
        joined.truncate(joined.trim_end().len());
        Some((number, Cow::Owned(joined)))
    }
}

/// The line without its `\`, if it goes on in the next one.
fn continued(line: &str) -> Option<&str> {
    if line.starts_with('#') { None } else { line.strip_suffix('\\') }
}

/// The first word of a statement and what follows it, trimmed.
#[inline]
pub(crate) fn split_keyword(statement: &str) -> (&str, &str) {
    match statement.find(|c: char| c.is_ascii_whitespace()) {
        Some(end) => (&statement[..end], statement[end..].trim_start()),
        None => (statement, ""),
    }
}

/// The words of a list of numbers or indices, up to one that begins with `#`. (Within a word it begins no comment:
/// `1.#IND` is how some programs write NaN. Names may hold it anywhere: `Material #25` is one.)
#[inline]
pub(crate) fn words(arguments: &str) -> impl Iterator<Item = &str> {
    arguments.split_ascii_whitespace().take_while(|word| !word.starts_with('#'))
}

/// A number, if it is finite.
#[inline]
pub(crate) fn finite(word: &str) -> Option<f64> {
    word.parse().ok().filter(|x: &f64| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    #[test]
    fn every_encoding_gives_the_same_text() {
        let text = "usemtl grün\n";
        let utf16 = |order: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(order).collect::<Vec<u8>>();
        assert_eq!(decode(text.as_bytes()), text);
        assert_eq!(decode(&[b"\xef\xbb\xbf", text.as_bytes()].concat()), text);
        assert_eq!(decode(&[vec![0xff, 0xfe], utf16(u16::to_le_bytes)].concat()), text);
        assert_eq!(decode(&[vec![0xfe, 0xff], utf16(u16::to_be_bytes)].concat()), text);
        assert_eq!(decode(b"usemtl gr\xfcn\n"), text);
    }

    #[test]
    fn lines_keep_their_numbers() {
        let text = "a\r\nb\rc \\\n 1 \\\r\n 2\n# C:\\\nd\n\ne \\";
        let found: Vec<_> = statements(text).filter(|(_, s)| !s.is_empty()).collect();
        let expected = [(1, "a"), (2, "b"), (3, "c  1  2"), (6, "# C:\\"), (7, "d"), (9, "e")];
        assert_eq!(found, expected.map(|(line, s)| (line, Cow::Borrowed(s))));
    }
}
