//! The front that every OBJ passes before tobj sees it.
//!
//! In: the text of a file. Out: the same polygons in the plainest dialect, with every index, number and arity checked,
//! or an error that names the line of the file as it is. The invariant: nothing that comes out makes tobj 4.0.5 panic,
//! refuse, or guess. So vertices come before faces (a file may name a vertex before it defines it); indices count from
//! the start; a corner without texture coordinates or normal names entry 1, which is NaN; materials are numbers; and
//! what has no area or no meaning here (points, lines, weights, colours, groups, names) is gone.

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use std::collections::HashMap;

use super::ImportError;
use crate::text::{Note, Notes, finite, quote, split_keyword, statements, words};

/// A file that was found right.
pub(super) struct Checked {
    /// `v`, `vt` and `vn` for tobj.
    pub(super) vertices: String,
    /// `f` and `usemtl N` for tobj, N being a place in `names`; `usemtl -` for faces without a material.
    pub(super) faces: String,
    /// What stands behind each `mtllib`, with its line.
    pub(super) libraries: Vec<(u32, String)>,
    /// Materials that faces use, in order of first use.
    pub(super) names: Vec<Used>,
    /// Line of the first face without a material.
    pub(super) bare: Option<u32>,
    /// Number of `f` statements.
    pub(super) polygons: usize,
}

/// A material that faces use.
pub(super) struct Used {
    pub(super) name: String,
    /// Line of the `usemtl` before its first face.
    pub(super) line: u32,
}

/// How many of `v`, `vt` and `vn` there are.
type Counts = [usize; 3];

const KINDS: [&str; 3] = ["v", "vt", "vn"];

/// The material of the faces that follow.
enum Current {
    Bare,
    /// Not used by a face yet: not among the names.
    Named(String, u32),
    Written,
}

pub(super) fn check(text: &str, notes: &mut Notes) -> Result<Checked, ImportError> {
    let totals = count(text)?;
    let mut out = Checked {
        vertices: String::with_capacity(text.len() / 2),
        faces: String::with_capacity(text.len() / 2),
        libraries: Vec::new(),
        names: Vec::new(),
        bare: None,
        polygons: 0,
    };
    // Entry 1 of both: what corners without them name.
    out.vertices.push_str("vt nan nan\nvn nan nan nan\n");
    let mut seen: Counts = [0; 3];
    let mut places = HashMap::new();
    let mut current = Current::Bare;
    let mut unknown = BTreeSet::new();
    let mut weighted = false;
    // Whether a corner named a `vt` or `vn` in a file that has none.
    let mut absent = [false; 3];
    for (line, statement) in statements(text) {
        if statement.is_empty() || statement.starts_with('#') {
            continue;
        }
        let (keyword, arguments) = split_keyword(&statement);
        let fail = |message: String| Err(ImportError(Note { file: String::new(), line, message }));
        match keyword {
            "v" => {
                seen[0] += 1;
                let (found, fourth) = match numbers::<7>(arguments) {
                    Ok(numbers) => numbers,
                    Err(message) => return fail(format!("v {}: {message}; correct the line", quote(arguments))),
                };
                if found < 3 {
                    return fail(format!(
                        "v has {found} numbers: expected 3 to 7 (x y z, then a weight or a colour); correct the line"
                    ));
                }
                if found == 4 && fourth != 1.0 && !weighted {
                    weighted = true;
                    let message =
                        format!("v has the weight {fourth}; weights mean nothing to polygons and are skipped");
                    notes.push("", line, message);
                }
                write(&mut out.vertices, "v", words(arguments).take(3));
            }
            "vt" | "vn" => {
                let normal = keyword == "vn";
                seen[1 + usize::from(normal)] += 1;
                let least = if normal { 3 } else { 1 };
                let found = match numbers::<3>(arguments) {
                    Ok((found, _)) => found,
                    Err(message) => {
                        return fail(format!("{keyword} {}: {message}; correct the line", quote(arguments)));
                    }
                };
                if found < least {
                    let expected = if normal { "3" } else { "1 to 3" };
                    return fail(format!("{keyword} has {found} numbers: expected {expected}; correct the line"));
                }
                let missing = if found == 1 { Some("0") } else { None };
                let kept = if normal { 3 } else { 2 };
                write(&mut out.vertices, keyword, words(arguments).chain(missing).take(kept));
            }
            // `fo` is what the format's first version called a face.
            "f" | "fo" => {
                // Name the face's material, if it is a new one.
                match core::mem::replace(&mut current, Current::Written) {
                    Current::Written => {}
                    Current::Bare => {
                        out.bare.get_or_insert(line);
                        out.faces.push_str("usemtl -\n");
                    }
                    Current::Named(name, line) => {
                        let place = *places.entry(name).or_insert_with_key(|name| {
                            out.names.push(Used { name: name.clone(), line });
                            out.names.len() - 1
                        });
                        out.faces.push_str("usemtl ");
                        push_number(&mut out.faces, place);
                        out.faces.push('\n');
                    }
                }

                // Write its corners.
                out.polygons += 1;
                out.faces.push('f');
                let warned = absent;
                let mut corners = 0;
                for word in words(arguments) {
                    if let Err(message) = corner(word, &seen, &totals, &mut absent, &mut out.faces) {
                        return fail(message);
                    }
                    corners += 1;
                }
                for kind in 1..3 {
                    if absent[kind] && !warned[kind] {
                        let name = KINDS[kind];
                        notes.push("", line, format!("faces name {name} entries, but the file has none; read without"));
                    }
                }
                if corners < 3 {
                    return fail(format!(
                        "a face has {corners} corners: expected at least 3; delete the line, or use l or p for lines and points"
                    ));
                }
                out.faces.push('\n');
            }
            "usemtl" if arguments.is_empty() => {
                notes.push("", line, "usemtl without a name; the faces that follow have no material".to_string());
                current = Current::Bare;
            }
            "usemtl" => current = Current::Named(arguments.to_string(), line),
            "mtllib" if arguments.is_empty() => {
                notes.push("", line, "mtllib names no file; it is skipped".to_string());
            }
            "mtllib" => out.libraries.push((line, arguments.to_string())),
            // Grouping, smoothing, and the display and rendering state of Wavefront's own programs.
            "o" | "g" | "s" | "mg" | "vp" | "lod" | "bevel" | "c_interp" | "d_interp" | "usemap" | "maplib"
            | "shadow_obj" | "trace_obj" => {}
            other => {
                if !unknown.contains(other) {
                    let what = match other {
                        "l" | "p" => "has no area",
                        _ => "is not read",
                    };
                    notes.push(
                        "",
                        line,
                        format!("statement {} {what}; it is skipped wherever it stands", quote(other)),
                    );
                    unknown.insert(other.to_string());
                }
            }
        }
    }
    Ok(out)
}

/// Counts the vertices first, because a face may name one that comes later.
fn count(text: &str) -> Result<Counts, ImportError> {
    let mut totals: Counts = [0; 3];
    for (line, statement) in statements(text) {
        if !statement.starts_with('v') {
            continue;
        }
        let (keyword, _) = split_keyword(&statement);
        if let Some(kind) = KINDS.iter().position(|kind| *kind == keyword) {
            totals[kind] += 1;
            // tobj's own numbers are u32; one is taken by the NaN entry.
            if totals[kind] >= u32::MAX as usize {
                let message = format!("more than 2^32 - 2 statements {keyword}; split the file");
                return Err(ImportError(Note { file: String::new(), line, message }));
            }
        }
    }
    Ok(totals)
}

/// How many numbers there are, at most `MOST`, and the fourth.
fn numbers<const MOST: usize>(arguments: &str) -> Result<(usize, f64), String> {
    let mut found = 0;
    let mut fourth = 0.0;
    for word in words(arguments) {
        let Some(x) = finite(word) else {
            return Err(format!("{} is not a finite number", quote(word)));
        };
        // Normals and texture coordinates are kept in single precision.
        if MOST == 3 && !(x as f32).is_finite() {
            return Err(format!("{} is too large for single precision", quote(word)));
        }
        found += 1;
        if found > MOST {
            return Err(format!("expected at most {MOST} numbers"));
        }
        if found == 4 {
            fourth = x;
        }
    }
    Ok((found, fourth))
}

fn write<'a>(out: &mut String, keyword: &str, words: impl Iterator<Item = &'a str>) {
    out.push_str(keyword);
    for word in words {
        out.push(' ');
        out.push_str(word);
    }
    out.push('\n');
}

/// Checks a corner (`v`, `v/vt`, `v//vn`, `v/vt/vn`) and writes it with indices from the start.
///
/// An index out of range is an error, but files that name texture coordinates or normals and have none at all are
/// common enough (they were stripped): these are read without, and `absent` says so.
fn corner(word: &str, seen: &Counts, totals: &Counts, absent: &mut [bool; 3], out: &mut String) -> Result<(), String> {
    let mut fields = word.split('/');
    for kind in 0..3 {
        let field = fields.next().unwrap_or("");
        let number = if field.is_empty() && kind > 0 {
            0
        } else if kind > 0 && totals[kind] == 0 && field.parse::<i64>().is_ok() {
            absent[kind] = true;
            0
        } else {
            index(field, kind, seen, totals).ok_or_else(|| explain(field, word, kind, seen, totals))?
        };
        // The entries of `vt` and `vn` begin behind that for none.
        out.push(if kind == 0 { ' ' } else { '/' });
        push_number(out, number + usize::from(kind > 0));
    }
    if fields.next().is_some() { Err(form(word)) } else { Ok(()) }
}

/// The entry that an index means, counted from 1.
fn index(field: &str, kind: usize, seen: &Counts, totals: &Counts) -> Option<usize> {
    let value: i64 = field.parse().ok()?;
    let entry = if value < 0 { (seen[kind] as i64).checked_add(value)?.checked_add(1)? } else { value };
    usize::try_from(entry).ok().filter(|entry| (1..=totals[kind]).contains(entry))
}

fn form(word: &str) -> String {
    format!("{} is not a corner: expected v, v/vt, v//vn or v/vt/vn; correct the line", quote(word))
}

/// Why an index means no entry.
fn explain(field: &str, word: &str, kind: usize, seen: &Counts, totals: &Counts) -> String {
    let Ok(value) = field.parse::<i64>() else { return form(word) };
    let name = KINDS[kind];
    match value {
        0 => format!("{name} index 0 in {}: indices count from 1, or from -1 backwards; correct the line", quote(word)),
        1.. => format!("{name} index {value} is out of range: the file has {} statements {name}", totals[kind]),
        _ => {
            format!("{name} index {value} is out of range: there are {} statements {name} before the line", seen[kind])
        }
    }
}

/// Decimal digits, without the detour over `fmt`: faces are most of a file.
fn push_number(out: &mut String, mut value: usize) {
    let mut digits = [0u8; 20];
    let mut start = digits.len();
    loop {
        start -= 1;
        digits[start] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    out.extend(digits[start..].iter().map(|&digit| char::from(digit)));
}
