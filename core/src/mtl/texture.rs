//! The arguments of a texture statement: `[-option values]... file name`.
//!
//! In: the rest of the line. Out: the file and what sampling needs. File names may hold spaces, backslashes and quotes;
//! some dialects put options behind the name. An option that is not known is a warning, never the end of the texture.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

use crate::text::{finite, path, quote, split_keyword};
use crate::texture::Placement;

/// A texture and how it lies on a surface.
#[derive(Clone, PartialEq, Debug)]
pub struct TextureMap {
    /// As the library names it, with `/` between folders.
    pub path: String,
    /// The library that names it, and the line.
    pub library: String,
    /// See `library`.
    pub line: u32,
    /// How it lies there, and how bright it is.
    pub placement: Placement,
}

impl TextureMap {
    /// Where its picture may lie, relative to the OBJ, each place once, the likeliest first: as the library says, relative
    /// to the library and to the OBJ, then by its bare name beside either.
    pub fn places(&self) -> Vec<String> {
        let folder = self.folder();
        let name = self.path.rsplit('/').next().unwrap_or(&self.path);
        let all = [format!("{folder}{}", self.path), self.path.clone(), format!("{folder}{name}"), name.into()];
        let mut places = Vec::new();
        for place in all {
            if !places.contains(&place) {
                places.push(place);
            }
        }
        places
    }

    /// The folder of the library, with the `/` behind it.
    pub(crate) fn folder(&self) -> &str {
        self.library.rfind('/').map_or("", |end| &self.library[..=end])
    }
}

/// What follows an option of a texture.
enum Arguments {
    /// One number, up to so many more.
    Numbers(usize),
    Switch,
    Word,
}

fn option(word: &str) -> Option<Arguments> {
    Some(match word {
        "-s" | "-o" | "-t" => Arguments::Numbers(3),
        "-mm" => Arguments::Numbers(2),
        "-bm" | "-boost" | "-texres" => Arguments::Numbers(1),
        "-clamp" | "-blendu" | "-blendv" | "-cc" => Arguments::Switch,
        "-imfchan" | "-type" | "-colorspace" => Arguments::Word,
        _ => return None,
    })
}

fn switch(word: &str) -> Option<bool> {
    if word.eq_ignore_ascii_case("on") {
        Some(true)
    } else if word.eq_ignore_ascii_case("off") {
        Some(false)
    } else {
        None
    }
}

/// Where a texture is named.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub statement: &'static str,
    pub library: &'a str,
    pub line: u32,
}

/// The arguments of a statement: options, a file name that may hold spaces, and options again in some dialects.
pub(super) fn read(
    arguments: &str,
    Place { statement, library, line }: Place<'_>,
    note: &mut impl FnMut(String),
) -> Option<TextureMap> {
    let mut map = TextureMap { path: String::new(), library: library.into(), line, placement: Placement::default() };
    let mut unknown = Vec::new();
    let mut rest = arguments;
    while !rest.is_empty() {
        let (word, after) = split_keyword(rest);
        let lower = word.to_ascii_lowercase();
        let Some(kind) = option(&lower) else {
            if map.path.is_empty() && word.starts_with('-') && !after.is_empty() {
                // How many arguments it has is not known either: all that cannot begin a file name.
                unknown.push(quote(word));
                rest = skip_while(after, |word| finite(word).is_some() || switch(word).is_some());
            } else if map.path.is_empty() {
                // The name ends at the next known option or at the end of the line.
                let end = skip_while(rest, |word| option(&word.to_ascii_lowercase()).is_none());
                map.path = path(&rest[..rest.len() - end.len()]);
                rest = end;
            } else {
                note(format!("{statement}: {} after the file name is skipped", quote(rest)));
                break;
            }
            continue;
        };
        rest = match kind {
            Arguments::Numbers(most) => read_numbers(&mut map, (statement, &lower), most, after, note),
            Arguments::Switch => {
                let (value, behind) = split_keyword(after);
                match switch(value) {
                    Some(on) => {
                        if lower == "-clamp" {
                            map.placement.clamp = on;
                        }
                        behind
                    }
                    None => {
                        note(format!(
                            "{statement}: option {lower} is followed by {}: expected on or off",
                            quote(value)
                        ));
                        after
                    }
                }
            }
            Arguments::Word => split_keyword(after).1,
        };
    }
    if map.path.is_empty() {
        note(format!("{statement} names no file; the statement is skipped"));
        return None;
    }
    for word in unknown {
        note(format!("option {word} of {statement} is not known; texture {} is used without it", quote(&map.path)));
    }
    Some(map)
}

/// Reads up to `most` numbers into the field of `option`, and gives what follows them.
fn read_numbers<'a>(
    map: &mut TextureMap,
    (statement, option): (&str, &str),
    most: usize,
    arguments: &'a str,
    note: &mut impl FnMut(String),
) -> &'a str {
    let mut rest = arguments;
    let mut values = [0.0f32; 3];
    let (mut count, mut is_finite) = (0, true);
    while count < most {
        let (word, behind) = split_keyword(rest);
        let Ok(value) = word.parse::<f32>() else { break };
        is_finite &= value.is_finite();
        values[count] = value;
        count += 1;
        rest = behind;
    }
    if !is_finite {
        let numbers = quote(arguments[..arguments.len() - rest.len()].trim_end());
        note(format!("{statement}: option {option} {numbers} is not finite in single precision; it is skipped"));
        return rest;
    }
    if count == 0 {
        note(format!("{statement}: option {option} has no number; it is skipped"));
        return rest;
    }
    match option {
        "-s" => map.placement.scale[..count].copy_from_slice(&values[..count]),
        "-o" => map.placement.offset[..count].copy_from_slice(&values[..count]),
        "-mm" => {
            map.placement.base = values[0];
            if count > 1 {
                map.placement.gain = values[1];
            }
        }
        _ => {}
    }
    rest
}

/// The words that follow those which `skip` takes.
fn skip_while(text: &str, skip: impl Fn(&str) -> bool) -> &str {
    let mut rest = text;
    while !rest.is_empty() {
        let (word, after) = split_keyword(rest);
        if !skip(word) {
            break;
        }
        rest = after;
    }
    rest
}
