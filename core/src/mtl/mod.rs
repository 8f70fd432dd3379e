//! Wavefront MTL: the materials of a scene.
//!
//! In: the bytes of a library. Out: materials in the order of the file, colours in linear light, and warnings with their
//! lines; a number that cannot be used leaves the field at its default, and no file is refused. The statements are those
//! of the Alias|Wavefront description ("MTL material format", 1995); statements of later dialects are skipped.
//!
//! The colour convention: the numbers of Ka, Kd, Ks, Ke and Tf are what authoring tools show, sRGB-encoded; they are
//! decoded here, once, with the piecewise curve of IEC 61966-2-1, which goes on above 1 for lights. Defaults: Kd that of
//! [`Material::GREY`] (white under a map_Kd), Ka as Kd, Ks and Ke black, Tf white, Ns 1, d 1, Ni 1, illum 2 with a Ks and
//! 1 without.

mod texture;

use alloc::collections::BTreeSet;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use std::collections::HashMap;

use crate::color::srgb_to_linear;
use crate::material::{MAX_SHININESS, Material};
use crate::text::{Notes, decode, finite, quote, split_keyword, statements, words};

pub use texture::TextureMap;

/// A material as a library defines it.
#[derive(Clone, PartialEq, Debug)]
pub struct NamedMaterial {
    /// Its name, without surrounding white space.
    pub name: String,
    /// Its parameters, colours in linear light.
    pub material: Material,
    /// Whether the library gives Ka; else it is Kd.
    pub has_ambient: bool,
    /// The texture of its diffuse colour.
    pub map_kd: Option<TextureMap>,
    /// The texture that says where there is any of it.
    pub map_d: Option<TextureMap>,
}

/// Materials a scene can have.
pub(crate) const MOST_MATERIALS: usize = 65_535;

/// The materials of all libraries read so far; ids are places in `list`.
#[derive(Default)]
pub(crate) struct Materials {
    pub(crate) list: Vec<NamedMaterial>,
    ids: HashMap<String, u16>,
    /// Unknown statements that were warned of.
    unknown: BTreeSet<String>,
}

impl Materials {
    pub(crate) fn id(&self, name: &str) -> Option<u16> {
        self.ids.get(name).copied()
    }

    /// Appends a material; `None` if there are [`MOST_MATERIALS`] already.
    pub(crate) fn push(&mut self, material: NamedMaterial) -> Option<u16> {
        if self.list.len() >= MOST_MATERIALS {
            return None;
        }
        let id = self.list.len() as u16;
        self.ids.insert(material.name.clone(), id);
        self.list.push(material);
        Some(id)
    }

    /// The grey stand-in for a name without a definition; `None` if there are too many materials already.
    pub(crate) fn push_grey(&mut self, name: &str) -> Option<u16> {
        let material = Material::GREY;
        self.push(NamedMaterial { name: name.into(), material, has_ambient: false, map_kd: None, map_d: None })
    }

    /// Reads a library. Of several definitions of a name the first counts, as in the search order of `mtllib`.
    /// Err: the line of the material that is one too many.
    pub(crate) fn read(&mut self, file: &str, bytes: &[u8], notes: &mut Notes) -> Result<(), u32> {
        let text = decode(bytes);
        let mut current: Option<(u32, Definition)> = None;
        let mut skipping = false;
        for (line, statement) in statements(&text) {
            if statement.is_empty() || statement.starts_with('#') {
                continue;
            }
            let (keyword, arguments) = split_keyword(&statement);
            let keyword = keyword.to_ascii_lowercase();
            if keyword == "newmtl" {
                self.finish(current.take())?;
                skipping = true;
                if arguments.is_empty() {
                    notes.push(file, line, "newmtl without a name; the material is skipped".into());
                } else if self.ids.contains_key(arguments) {
                    let name = quote(arguments);
                    notes.push(file, line, format!("material {name} is defined again; the first definition counts"));
                } else {
                    skipping = false;
                    current = Some((line, Definition::new(arguments)));
                }
                continue;
            }
            let mut note = |message: String| notes.push(file, line, message);
            match &mut current {
                Some((_, definition)) => {
                    if !definition.read(&keyword, arguments, (file, line), &mut note)
                        && !self.unknown.contains(&keyword)
                    {
                        note(format!("statement {} is not known and is skipped, here and elsewhere", quote(&keyword)));
                        self.unknown.insert(keyword);
                    }
                }
                None if skipping => {}
                None => {
                    skipping = true;
                    note(format!("{} before the first newmtl is skipped", quote(&keyword)));
                }
            }
        }
        self.finish(current)
    }

    fn finish(&mut self, definition: Option<(u32, Definition)>) -> Result<(), u32> {
        match definition {
            Some((line, definition)) => self.push(definition.finish()).map(|_| ()).ok_or(line),
            None => Ok(()),
        }
    }
}

/// A material while its statements are read.
struct Definition {
    name: String,
    ambient: Option<[f32; 3]>,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emission: Option<[f32; 3]>,
    transmission: Option<[f32; 3]>,
    shininess: Option<f64>,
    illum: Option<u8>,
    dissolve: Option<f64>,
    transparency: Option<f64>,
    refraction: Option<f64>,
    map_kd: Option<TextureMap>,
    map_d: Option<TextureMap>,
}

impl Definition {
    fn new(name: &str) -> Definition {
        Definition {
            name: name.into(),
            ambient: None,
            diffuse: None,
            specular: None,
            emission: None,
            transmission: None,
            shininess: None,
            illum: None,
            dissolve: None,
            transparency: None,
            refraction: None,
            map_kd: None,
            map_d: None,
        }
    }

    /// Reads a statement (`keyword` in lower case); false if there is none of that name.
    fn read(
        &mut self,
        keyword: &str,
        arguments: &str,
        (library, line): (&str, u32),
        note: &mut impl FnMut(String),
    ) -> bool {
        let at = |statement| texture::Place { statement, library, line };
        match keyword {
            "ka" => set(&mut self.ambient, color("Ka", arguments), note),
            "kd" => set(&mut self.diffuse, color("Kd", arguments), note),
            "ks" => set(&mut self.specular, color("Ks", arguments), note),
            "ke" => set(&mut self.emission, color("Ke", arguments), note),
            "tf" => set(&mut self.transmission, color("Tf", arguments), note),
            "ns" => set(&mut self.shininess, number("Ns", arguments), note),
            "ni" => set(&mut self.refraction, number("Ni", arguments), note),
            "illum" => set(&mut self.illum, model(arguments), note),
            "d" => {
                let (first, rest) = split_keyword(arguments);
                let factor = if first.eq_ignore_ascii_case("-halo") { rest } else { arguments };
                set(&mut self.dissolve, number("d", factor), note);
                self.compare_dissolve(note);
            }
            "tr" => {
                set(&mut self.transparency, number("Tr", arguments), note);
                self.compare_dissolve(note);
            }
            "map_kd" => {
                let map = texture::read(arguments, at("map_Kd"), note);
                self.map_kd = map.or(self.map_kd.take());
            }
            "map_d" => {
                let map = texture::read(arguments, at("map_d"), note);
                self.map_d = map.or(self.map_d.take());
            }
            // Other maps, and what physically based dialects add.
            "bump" | "disp" | "decal" | "refl" | "norm" | "sharpness" | "km" | "kt" | "pr" | "pm" | "ps" | "pc"
            | "pcr" | "aniso" | "anisor" => {}
            _ => return keyword.starts_with("map_"),
        }
        true
    }

    fn compare_dissolve(&self, note: &mut impl FnMut(String)) {
        if let (Some(d), Some(tr)) = (self.dissolve, self.transparency)
            && (d + tr - 1.0).abs() > 1e-3
        {
            note(format!("d {d} and Tr {tr} disagree (Tr means 1 - d); d counts"));
        }
    }

    fn finish(self) -> NamedMaterial {
        let grey = Material::GREY;
        let diffuse = self.diffuse.unwrap_or(if self.map_kd.is_some() { [1.0; 3] } else { grey.diffuse });
        let specular = self.specular.unwrap_or(grey.specular);
        let shininess = self.shininess.map_or(grey.shininess, |ns| libm::round(ns) as u32);
        let opacity = self.dissolve.or(self.transparency.map(|tr| 1.0 - tr));
        let material = Material {
            ambient: self.ambient.unwrap_or(diffuse),
            diffuse,
            specular,
            emission: self.emission.unwrap_or(grey.emission),
            transmission: self.transmission.unwrap_or(grey.transmission),
            shininess: shininess.clamp(1, MAX_SHININESS),
            opacity: opacity.map_or(grey.opacity, |d| d.clamp(0.0, 1.0) as f32),
            refraction: self.refraction.map_or(grey.refraction, |ni| ni as f32),
            illum: self.illum.unwrap_or(if specular == [0.0; 3] { 1 } else { 2 }),
            textured: false,
        };
        let has_ambient = self.ambient.is_some();
        NamedMaterial { name: self.name, material, has_ambient, map_kd: self.map_kd, map_d: self.map_d }
    }
}

impl NamedMaterial {
    /// Another Kd, also for the Ka that follows it.
    pub(crate) fn set_diffuse(&mut self, diffuse: [f32; 3]) {
        self.material.diffuse = diffuse;
        if !self.has_ambient {
            self.material.ambient = diffuse;
        }
    }
}

/// Takes a field's value, or notes why it keeps the one it has.
fn set<T>(field: &mut Option<T>, value: Result<T, String>, note: &mut impl FnMut(String)) {
    match value {
        Ok(value) => *field = Some(value),
        Err(message) => note(message),
    }
}

/// A number of 0 or more that `f32` can hold.
fn amount(word: &str) -> Option<f64> {
    finite(word).filter(|x| *x >= 0.0 && (*x as f32).is_finite())
}

fn number(keyword: &str, arguments: &str) -> Result<f64, String> {
    let word = words(arguments).next().unwrap_or("");
    amount(word)
        .ok_or_else(|| format!("{keyword} {} is not a number of 0 or more; the statement is skipped", quote(word)))
}

fn model(arguments: &str) -> Result<u8, String> {
    let word = words(arguments).next().unwrap_or("");
    let whole = finite(word).filter(|x| (0.0..=10.0).contains(x) && libm::floor(*x) == *x);
    whole.map(|x| x as u8).ok_or_else(|| {
        format!("illum {} is not an illumination model (0 to 10); the statement is skipped", quote(word))
    })
}

/// `r`, or `r g b`, decoded to linear light.
fn color(keyword: &str, arguments: &str) -> Result<[f32; 3], String> {
    let mut list = words(arguments);
    let first = list.next().unwrap_or("");
    if first.eq_ignore_ascii_case("spectral") || first.eq_ignore_ascii_case("xyz") {
        return Err(format!("{keyword} {first} is not read (only red, green, blue are); the statement is skipped"));
    }
    let channels = match (list.next(), list.next()) {
        (None, _) => [first; 3],
        (Some(green), Some(blue)) => [first, green, blue],
        (Some(green), None) => [first, green, ""],
    };
    let mut rgb = [0.0; 3];
    for (linear, word) in rgb.iter_mut().zip(channels) {
        *linear = amount(word).map(|x| srgb_to_linear(x) as f32).filter(|x| x.is_finite()).ok_or_else(|| {
            let found = quote(arguments);
            format!("{keyword} {found}: expected one or three numbers of 0 or more; the statement is skipped")
        })?;
    }
    Ok(rgb)
}
