//! What a command says at its end: aligned lines for people or one JSON object for programs, both on stdout; warnings
//! and the next command to type on stderr.

use std::io::{IsTerminal, Write};
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use voxdag::layout::AnyGeometry;
use voxdag::materials::AnyMaterials;

use crate::error::{Error, Kind, Result};

/// Rows of a label and what there is to say about it.
#[derive(Default)]
pub struct Lines(Vec<(String, String)>);

impl Lines {
    /// Adds a row.
    pub fn row(&mut self, label: impl Into<String>, value: impl Into<String>) -> &mut Lines {
        self.0.push((label.into(), value.into()));
        self
    }

    /// The rows below each other, their values aligned.
    fn text(&self) -> String {
        let width = self.0.iter().map(|(label, _)| visible(label).chars().count()).max().unwrap_or(0);
        let line = |label: &str, value: &str| format!("{label:width$}  {value}").trim_end().to_owned() + "\n";
        self.0.iter().map(|(label, value)| line(&visible(label), &visible(value))).collect()
    }
}

/// Prints the result to stdout: `data` as JSON if asked for, otherwise the lines.
pub fn result(json: bool, data: &impl Serialize, lines: &Lines) -> Result<()> {
    let text = if json {
        // Keys stay in the order of the fields; f64 are written with the digits that bring the same bits back.
        serde_json::to_string_pretty(data).map_err(|e| Error::new(Kind::Failure, e))? + "\n"
    } else {
        lines.text()
    };
    print(text.as_bytes())
}

/// Writes to stdout.
pub fn print(text: &[u8]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        // A reader that has seen enough (`| head`) is no failure.
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::new(Kind::Failure, format_args!("cannot write to stdout: {e}")))
        }
        _ => Ok(()),
    }
}

/// Prints a warning: the run goes on.
pub fn warning(message: impl std::fmt::Display) {
    eprintln!("warning: {}", visible(&message.to_string()));
}

/// Prints the next command to type: `arguments` follow the program's name, paths as [`shell_word`] gives them.
pub fn next(arguments: impl std::fmt::Display) {
    // An empty line sets it apart from the result where both end up on one screen.
    let gap = if std::io::stdout().is_terminal() && std::io::stderr().is_terminal() { "\n" } else { "" };
    eprintln!("{gap}next: {}", visible(&format!("{} {arguments}", program())));
}

/// The text with its control characters escaped: names in files must not steer the terminal.
pub fn visible(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { out.extend(c.escape_debug()) } else { out.push(c) }
    }
    out
}

/// The arguments of this run as they must be typed.
pub fn typed() -> String {
    std::env::args_os().skip(1).map(|word| shell_word(Path::new(&word))).collect::<Vec<_>>().join(" ")
}

/// A path as it must be typed: in quotes if the shell would take it apart.
pub fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/\\._-+,=:@%".contains(c);
    if !text.is_empty() && text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// The program as it was called: through cargo, by a path, or by its name.
fn program() -> String {
    let typed = std::env::args_os().next().unwrap_or_default();
    let typed = Path::new(&typed);
    let in_target = typed.components().any(|part| part.as_os_str() == "target");
    if in_target && std::env::var_os("CARGO_MANIFEST_DIR").is_some() {
        return if cfg!(debug_assertions) { "cargo run --" } else { "cargo run --release --" }.to_owned();
    }
    if typed.as_os_str().is_empty() { "voxdag".to_owned() } else { shell_word(typed) }
}

/// A whole number with its digits in groups of three.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut out = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A number of bytes in the unit that suits it.
pub fn size(bytes: u64) -> String {
    const UNITS: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let mut unit = 0;
    let mut value = bytes as f64;
    while value >= 1024.0 && unit + 1 < UNITS.len() {
        value /= 1024.0;
        unit += 1;
    }
    match unit {
        0 => format!("{bytes} bytes"),
        _ if value < 10.0 => format!("{value:.2} {}", UNITS[unit]),
        _ => format!("{value:.1} {}", UNITS[unit]),
    }
}

/// A time, with as many digits as mean something.
pub fn time(ms: f64) -> String {
    match ms {
        ..10.0 => format!("{ms:.1} ms"),
        ..1000.0 => format!("{ms:.0} ms"),
        ..10_000.0 => format!("{:.2} s", ms / 1000.0),
        _ => format!("{:.1} s", ms / 1000.0),
    }
}

/// A number with the digits that bring the same bits back.
pub fn number(x: f64) -> String {
    if x == 0.0 || (1e-4..1e16).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

/// How much sharing saves: nodes of the octree, and unique nodes of the DAG.
pub fn sharing(octree: u64, dag: u64) -> String {
    let percent = if octree == 0 { 100.0 } else { 100.0 * dag as f64 / octree as f64 };
    format!("octree {} -> DAG {} ({percent:.2} %), bricks included", grouped(octree), grouped(dag))
}

/// The layout of a geometry, as `--geometry` names it.
pub fn geometry_kind(geometry: AnyGeometry<'_>) -> &'static str {
    match geometry {
        AnyGeometry::Dag(_) => "dag",
        AnyGeometry::Ssvdag(_) => "ssvdag",
        AnyGeometry::Svo(_) => "svo",
        AnyGeometry::Offsets(_) => "offsets",
        AnyGeometry::MoxelDag(_) => "moxel",
    }
}

/// The representation of materials, as `--materials` names it.
pub fn materials_kind(materials: AnyMaterials<'_>) -> &'static str {
    match (materials, materials.has_normals()) {
        (AnyMaterials::Single(_), _) => "none",
        (AnyMaterials::Tree(_), _) => "tree",
        (AnyMaterials::Table(_), false) => "table",
        (AnyMaterials::Table(_), true) => "table-normals",
        (AnyMaterials::Ranked(_), _) => "ranked",
        (AnyMaterials::Palettes(_), _) => "palette",
        (AnyMaterials::Moxels(_), false) => "moxel",
        (AnyMaterials::Moxels(_), true) => "moxel-normals",
    }
}

/// The peak of memory, where the system says it.
pub fn peak(bytes: Option<u64>) -> String {
    bytes.map_or("peak unknown on this system".to_owned(), |bytes| format!("{} at its peak", size(bytes)))
}

/// Three numbers, each with the digits that bring the same bits back.
pub fn triple(v: [f64; 3]) -> String {
    v.map(number).join(", ")
}

/// A name that file systems and links take as it is.
pub fn file_name(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
    name.chars().map(plain).collect()
}

/// A PNG as the address of an image that is part of a page.
pub fn data_url(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_and_sized() {
        assert_eq!([0, 999, 1000, 8_213_456].map(grouped), ["0", "999", "1,000", "8,213,456"]);
        assert_eq!(
            [0, 1023, 1024, 999_376, 1 << 30].map(size),
            ["0 bytes", "1023 bytes", "1.00 KiB", "976.0 KiB", "1.00 GiB"]
        );
    }

    #[test]
    fn times_and_numbers() {
        assert_eq!([0.26, 54.57, 912.0, 3160.0, 12_449.0].map(time), ["0.3 ms", "55 ms", "912 ms", "3.16 s", "12.4 s"]);
        for x in [0.0, -0.1, 1.0 / 3.0, 5e-324, 1e-9, f64::MAX] {
            assert_eq!(number(x).parse(), Ok(x));
            assert!(number(x).len() < 28, "{}", number(x));
        }
    }

    #[test]
    fn control_characters_are_shown_and_nothing_else_is_changed() {
        assert_eq!(visible("a\x1b[31m\n\u{9b}'\"\\ö"), "a\\u{1b}[31m\\n\\u{9b}'\"\\ö");
        let mut lines = Lines::default();
        lines.row("a\tb", "c\rd");
        assert_eq!(lines.text(), "a\\tb  c\\rd\n");
    }

    #[test]
    fn paths_are_quoted_only_where_a_shell_needs_it() {
        assert_eq!(shell_word(Path::new("a/b-1.vxd")), "a/b-1.vxd");
        assert_eq!(shell_word(Path::new("my bunny.vxd")), "'my bunny.vxd'");
        assert_eq!(shell_word(Path::new("it's")), r"'it'\''s'");
    }
}
