//! The front that every OBJ passes before tobj sees it.
//!
//! In: the text of a file. Out: the same polygons in the plainest dialect, with every index, number and arity checked,
//! or an error that names the line of the file as it is. The invariant: nothing that comes out makes tobj 4.0.5 panic,
//! refuse, or guess. So vertices come before faces (a file may name a vertex before it defines it); indices count from
//! the start; where others have texture coordinates or normals, a corner without names entry 1, which is NaN; materials are numbers; and
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
const V: usize = 0;
const VT: usize = 1;
const VN: usize = 2;

/// The material of the faces that follow.
enum Current {
    Bare,
    /// Not used by a face yet: not among the names.
    Named(String, u32),
    Written,
}

/// What is known while the file is read.
struct Front<'n> {
    out: Checked,
    notes: &'n mut Notes,
    totals: Counts,
    /// Those above the current line.
    seen: Counts,
    /// Places in `out.names`.
    places: HashMap<String, usize>,
    current: Current,
    /// Whether there was a warning of a weight, ...
    weighted: bool,
    /// ... of a `vt` or `vn` named by a corner in a file that has none, ...
    absent: [bool; 3],
    /// ... and of these statements.
    skipped: BTreeSet<String>,
}

/// Cutting a polygon takes time in proportion to the square of its corners: about a second for this many.
const MAX_CORNERS: u32 = 10_000;

pub(super) fn check(text: &str, notes: &mut Notes) -> Result<Checked, ImportError> {
    let mut front = Front {
        out: Checked {
            vertices: String::new(),
            faces: String::new(),
            libraries: Vec::new(),
            names: Vec::new(),
            bare: None,
            polygons: 0,
        },
        notes,
        totals: count(text)?,
        seen: [0; 3],
        places: HashMap::new(),
        current: Current::Bare,
        weighted: false,
        absent: [false; 3],
        skipped: BTreeSet::new(),
    };
    // Entry 1: what corners without one name.
    for (kind, entry) in [(VT, "vt nan nan\n"), (VN, "vn nan nan nan\n")] {
        if front.totals[kind] > 0 {
            front.out.vertices.push_str(entry);
        }
    }
    for (line, statement) in statements(text) {
        if !statement.is_empty() && !statement.starts_with('#') {
            let (keyword, arguments) = split_keyword(&statement);
            front
                .statement(line, keyword, arguments)
                .map_err(|message| ImportError(Note { file: String::new(), line, message }))?;
        }
    }
    Ok(front.out)
}

impl Front<'_> {
    /// Checks a statement and writes what is left of it. Err: what is wrong.
    fn statement(&mut self, line: u32, keyword: &str, arguments: &str) -> Result<(), String> {
        match keyword {
            "v" => self.vertex(line, arguments)?,
            "vt" => self.attribute(VT, arguments)?,
            "vn" => self.attribute(VN, arguments)?,
            // `fo` is what the format's first version called a face.
            "f" | "fo" => {
                self.material(line);
                self.face(line, arguments)?;
            }
            "usemtl" if arguments.is_empty() => {
                self.notes.push("", line, "usemtl without a name; the faces that follow have no material".to_string());
                self.current = Current::Bare;
            }
            "usemtl" => self.current = Current::Named(arguments.to_string(), line),
            "mtllib" if arguments.is_empty() => {
                self.notes.push("", line, "mtllib names no file; it is skipped".to_string());
            }
            "mtllib" => self.out.libraries.push((line, arguments.to_string())),
            // Grouping, smoothing, and the display and rendering state of Wavefront's own programs.
            "o" | "g" | "s" | "mg" | "vp" | "lod" | "bevel" | "c_interp" | "d_interp" | "usemap" | "maplib"
            | "shadow_obj" | "trace_obj" => {}
            other => {
                if !self.skipped.contains(other) {
                    let why = if matches!(other, "l" | "p") { "has no area" } else { "is not read" };
                    let message = format!("statement {} {why}; it is skipped wherever it stands", quote(other));
                    self.notes.push("", line, message);
                    self.skipped.insert(other.to_string());
                }
            }
        }
        Ok(())
    }

    fn vertex(&mut self, line: u32, arguments: &str) -> Result<(), String> {
        self.seen[V] += 1;
        let (found, fourth) =
            numbers::<7>(arguments).map_err(|why| format!("v {}: {why}; correct the line", quote(arguments)))?;
        if found < 3 {
            return Err(format!(
                "v has {found} numbers: expected 3 to 7 (x y z, then a weight or a colour); correct the line"
            ));
        }
        if found == 4 && fourth != 1.0 && !self.weighted {
            self.weighted = true;
            let message = format!("v has the weight {fourth}; weights mean nothing to polygons and are skipped");
            self.notes.push("", line, message);
        }
        write(&mut self.out.vertices, "v", words(arguments).take(3));
        Ok(())
    }

    /// Texture coordinates (one is enough, two are kept) or a normal.
    fn attribute(&mut self, kind: usize, arguments: &str) -> Result<(), String> {
        self.seen[kind] += 1;
        let name = KINDS[kind];
        let (expected, least, kept) = if kind == VN { ("3", 3, 3) } else { ("1 to 3", 1, 2) };
        let (found, _) =
            numbers::<3>(arguments).map_err(|why| format!("{name} {}: {why}; correct the line", quote(arguments)))?;
        if found < least {
            return Err(format!("{name} has {found} numbers: expected {expected}; correct the line"));
        }
        let missing = if found == 1 { Some("0") } else { None };
        write(&mut self.out.vertices, name, words(arguments).chain(missing).take(kept));
        Ok(())
    }

    /// Writes the material of the face on this line, if it is not that of the face before.
    fn material(&mut self, line: u32) {
        match core::mem::replace(&mut self.current, Current::Written) {
            Current::Written => {}
            Current::Bare => {
                self.out.bare.get_or_insert(line);
                self.out.faces.push_str("usemtl -\n");
            }
            Current::Named(name, line) => {
                let names = &mut self.out.names;
                let place = *self.places.entry(name).or_insert_with_key(|name| {
                    names.push(Used { name: name.clone(), line });
                    names.len() - 1
                });
                self.out.faces.push_str("usemtl ");
                push_number(&mut self.out.faces, place);
                self.out.faces.push('\n');
            }
        }
    }

    fn face(&mut self, line: u32, arguments: &str) -> Result<(), String> {
        self.out.polygons += 1;
        self.out.faces.push('f');
        let warned = self.absent;
        let mut corners = 0;
        for word in words(arguments) {
            self.corner(word)?;
            corners += 1;
        }
        self.out.faces.push('\n');
        for kind in [VT, VN] {
            if self.absent[kind] && !warned[kind] {
                let message = format!("faces name {} entries, but the file has none; read without", KINDS[kind]);
                self.notes.push("", line, message);
            }
        }
        if corners < 3 {
            let hint = "delete the line, or use l or p for lines and points";
            return Err(format!("a face has {corners} corners: expected at least 3; {hint}"));
        }
        if corners > MAX_CORNERS {
            return Err(format!(
                "a face has {corners} corners: expected at most {MAX_CORNERS}; cut it into smaller ones"
            ));
        }
        Ok(())
    }

    /// Checks a corner (`v`, `v/vt`, `v//vn`, `v/vt/vn`) and writes it with indices from the start.
    ///
    /// An index out of range is an error, but files that name texture coordinates or normals and have none at all are
    /// common enough (they were stripped): these are read without.
    fn corner(&mut self, word: &str) -> Result<(), String> {
        let mut fields = word.split('/');
        for kind in [V, VT, VN] {
            let field = fields.next().unwrap_or("");
            let number = if field.is_empty() && kind != V {
                0
            } else if kind != V && self.totals[kind] == 0 && field.parse::<i64>().is_ok() {
                self.absent[kind] = true;
                0
            } else {
                self.index(field, kind).ok_or_else(|| self.explain(field, word, kind))?
            };
            let out = &mut self.out.faces;
            if kind == V {
                out.push(' ');
                push_number(out, number);
            } else if self.totals[kind] > 0 {
                // The entries begin behind that for none.
                out.push('/');
                push_number(out, number + 1);
            } else if self.totals[VN] > 0 {
                out.push('/');
            }
        }
        if fields.next().is_some() { Err(form(word)) } else { Ok(()) }
    }

    /// The entry that an index means, counted from 1.
    fn index(&self, field: &str, kind: usize) -> Option<usize> {
        let value: i64 = field.parse().ok()?;
        let entry = if value < 0 { (self.seen[kind] as i64).checked_add(value)?.checked_add(1)? } else { value };
        usize::try_from(entry).ok().filter(|entry| (1..=self.totals[kind]).contains(entry))
    }

    /// Why an index means no entry.
    fn explain(&self, field: &str, word: &str, kind: usize) -> String {
        let Ok(value) = field.parse::<i64>() else { return form(word) };
        let (name, total, seen) = (KINDS[kind], self.totals[kind], self.seen[kind]);
        match value {
            0 => {
                let word = quote(word);
                format!("{name} index 0 in {word}: indices count from 1, or from -1 backwards; correct the line")
            }
            1.. => format!("{name} index {value} is out of range: the file has {total} statements {name}"),
            _ => format!("{name} index {value} is out of range: there are {seen} statements {name} before the line"),
        }
    }
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

fn form(word: &str) -> String {
    format!("{} is not a corner: expected v, v/vt, v//vn or v/vt/vn; correct the line", quote(word))
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
