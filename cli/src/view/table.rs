//! TOML tables, taken apart key by key so that whatever is wrong in them has a place.
//!
//! In: the text of a file. Out: the values of the keys that a reader asks for, each through a function that checks it. A
//! key that no one asked for is an error as well. Lines are counted from the byte where a value, key or header begins.

use std::fmt::Display;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{Error, Kind};

/// What is wrong, and the byte where it stands.
#[derive(Debug)]
pub struct Problem {
    at: usize,
    message: String,
}

impl Problem {
    /// At a byte of the file.
    pub fn new(at: usize, message: impl Display) -> Problem {
        Problem { at, message: message.to_string() }
    }

    /// With the file's name and the number of the line, from 1.
    pub fn in_file(&self, path: &Path, file: &[u8]) -> Error {
        let line = 1 + file.iter().take(self.at).filter(|byte| **byte == b'\n').count();
        let message = format_args!("{}:{line}: {}", path.display(), self.message);
        Error::new(Kind::BadInput, message).hint("see docs/view.md for what can stand there")
    }
}

/// A table whose keys have yet to be asked for.
pub struct Table<'t> {
    /// What messages about it begin with.
    name: String,
    /// Where it begins.
    at: usize,
    entries: DeTable<'t>,
    /// The keys that were asked for.
    known: Vec<&'static str>,
}

impl<'t> Table<'t> {
    /// The whole of a file.
    pub fn parse(text: &'t str) -> Result<Table<'t>, Problem> {
        let table = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(text.len(), |span| span.start);
            Problem { at, message: format!("is not TOML: {}", error.message()) }
        })?;
        Ok(Table { name: String::new(), at: 0, entries: table.into_inner(), known: Vec::new() })
    }

    /// Something that is wrong with the table as a whole.
    pub fn problem(&self, message: impl Display) -> Problem {
        Problem::new(self.at, format_args!("{}{message}", self.name))
    }

    /// The value of a key, if it is there.
    pub fn take<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&DeValue<'_>) -> Result<T, String>,
    ) -> Result<Option<T>, Problem> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        let wrong = |message| Problem { at: value.span().start, message: format!("{}{key}: {message}", self.name) };
        read(value.get_ref()).map(Some).map_err(wrong)
    }

    /// The same, and it must be there.
    pub fn need<T>(
        &mut self,
        key: &'static str,
        read: impl FnOnce(&DeValue<'_>) -> Result<T, String>,
    ) -> Result<T, Problem> {
        self.take(key, read)?.ok_or_else(|| self.problem(format_args!("expected {key} = ...")))
    }

    /// The table of a key, if it is there.
    pub fn table(&mut self, key: &'static str) -> Result<Option<Table<'t>>, Problem> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        self.inner(value, key).map(Some)
    }

    /// The tables that share a key, in their order.
    pub fn tables(&mut self, key: &'static str) -> Result<Vec<Table<'t>>, Problem> {
        let Some(value) = self.entry(key) else { return Ok(Vec::new()) };
        let at = value.span().start;
        match value.into_inner() {
            DeValue::Array(found) => {
                found.into_iter().enumerate().map(|(i, value)| self.inner(value, &format!("{key} {}", i + 1))).collect()
            }
            found => {
                let message = format!("{}{key}: expected [[{key}]], found {}", self.name, kind(&found));
                Err(Problem { at, message })
            }
        }
    }

    /// That nothing is left.
    pub fn finish(self) -> Result<(), Problem> {
        let left = self.entries.keys().min_by_key(|key| key.span().start);
        left.map_or(Ok(()), |key| {
            let (found, expected) = (key.get_ref(), self.known.join(", "));
            let message = format!("{}unknown key `{found}`: expected {expected}", self.name);
            Err(Problem { at: key.span().start, message })
        })
    }

    fn entry(&mut self, key: &'static str) -> Option<Spanned<DeValue<'t>>> {
        self.known.push(key);
        self.entries.remove(key)
    }

    fn inner(&self, value: Spanned<DeValue<'t>>, name: &str) -> Result<Table<'t>, Problem> {
        let (at, name) = (value.span().start, format!("{}{name}: ", self.name));
        match value.into_inner() {
            DeValue::Table(entries) => Ok(Table { name, at, entries, known: Vec::new() }),
            found => Err(Problem { at, message: format!("{name}expected a table, found {}", kind(&found)) }),
        }
    }
}

/// Reads a number, whole or not.
pub fn number(value: &DeValue<'_>) -> Result<f64, String> {
    let found = match value {
        DeValue::Integer(x) => i128::from_str_radix(x.as_str(), x.radix()).ok().map(|x| x as f64),
        DeValue::Float(x) => x.as_str().parse().ok(),
        found => return Err(format!("expected a number, found {}", kind(found))),
    };
    found.filter(|x| x.is_finite()).ok_or_else(|| "expected a finite number".to_owned())
}

/// Reads numbers in brackets, or a single one.
pub fn numbers(value: &DeValue<'_>) -> Result<Vec<f64>, String> {
    match value {
        DeValue::Array(found) => found.iter().map(|value| number(value.get_ref())).collect(),
        value => Ok(vec![number(value)?]),
    }
}

/// Reads a whole number of a range.
pub fn whole(value: &DeValue<'_>, largest: u32) -> Result<u32, String> {
    let found = match value {
        DeValue::Integer(x) => u32::from_str_radix(x.as_str(), x.radix()).ok(),
        _ => None,
    };
    let found = found.filter(|x| (1..=largest).contains(x));
    found.ok_or_else(|| format!("expected a whole number from 1 to {largest}"))
}

/// Reads words in quotes.
pub fn text_of(value: &DeValue<'_>) -> Result<String, String> {
    let found = value.as_str().ok_or_else(|| format!("expected a string, found {}", kind(value)))?;
    Ok(found.to_owned())
}

/// Reads yes or no.
pub fn switch(value: &DeValue<'_>) -> Result<bool, String> {
    value.as_bool().ok_or_else(|| format!("expected true or false, found {}", kind(value)))
}

/// A value's type, with its article.
pub fn kind(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date or time",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
