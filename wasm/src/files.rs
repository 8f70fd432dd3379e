//! Files that were dropped or chosen together: names and bytes, as a page has them.
//!
//! A mesh names its libraries and textures by paths from its own folder. Pages may know folders, or names alone: so a path is
//! looked up as it is, then without regard to case, then by its last part. That is all that stands in for a file system.

use std::collections::BTreeMap;

use voxdag::demo;
use voxdag::texture::{DecodeError, Image};
use wasm_bindgen::prelude::*;

use crate::error;

/// Files by name, `/` between folders.
#[wasm_bindgen]
#[derive(Default)]
pub struct Files(BTreeMap<String, Content>);

/// What is in a file.
enum Content {
    Bytes(Vec<u8>),
    /// A picture that was decoded: width, height and RGBA8. Browsers can do that; decoders would be a third of the module.
    Picture([u32; 2], Vec<u8>),
}

#[wasm_bindgen]
impl Files {
    /// No files.
    #[wasm_bindgen(constructor)]
    pub fn new() -> Files {
        Files::default()
    }

    /// The scene that comes along.
    pub fn demo() -> Files {
        let mut files = Files::new();
        files.add("voxdag-demo.obj", demo::obj().into_bytes());
        files.add(demo::MTL_NAME, demo::mtl().into_bytes());
        files
    }

    /// Adds a file, or replaces the one of this name.
    pub fn add(&mut self, name: &str, bytes: Vec<u8>) {
        self.0.insert(plain(name), Content::Bytes(bytes));
    }

    /// Adds a picture for materials, decoded: its pixels from the upper left on, red, green, blue and alpha, as in
    /// `context.getImageData(0, 0, width, height).data`.
    #[wasm_bindgen(js_name = addPicture)]
    pub fn add_picture(&mut self, name: &str, width: u32, height: u32, pixels: Vec<u8>) {
        self.0.insert(plain(name), Content::Picture([width, height], pixels));
    }

    /// The name of the file that the others belong to: the one scene (`.vxd`), or else the largest mesh (`.obj`).
    #[wasm_bindgen(getter)]
    pub fn main(&self) -> Result<String, JsError> {
        let largest = |extension: &str| {
            let of_kind = self.0.iter().filter(|(name, _)| name.to_ascii_lowercase().ends_with(extension));
            of_kind.max_by_key(|(_, content)| content.bytes().len()).map(|(name, _)| name.clone())
        };
        largest(".vxd").or_else(|| largest(".obj")).ok_or_else(|| match self.0.keys().next() {
            Some(name) => error(format!("{name}: expected a mesh (.obj) among the files, or a scene (.vxd)")),
            None => error("there are no files: expected a mesh (.obj) with what it names, or a scene (.vxd)"),
        })
    }
}

impl Files {
    /// The bytes of a file.
    pub(crate) fn get(&self, name: &str) -> Option<&[u8]> {
        self.0.get(name).map(Content::bytes)
    }

    /// The picture that `from` names by `path`, if it takes at most `left` bytes.
    pub(crate) fn picture(&self, from: &str, path: &str, left: u64) -> Option<Result<Image, DecodeError>> {
        Some(match self.find(from, path)? {
            Content::Bytes(_) => Err(DecodeError::Picture("it was not decoded: browsers know PNG, JPEG, BMP".into())),
            Content::Picture([width, height], pixels) => {
                // As it is kept, and its halves.
                let needed = 6 * u64::from(*width) * u64::from(*height);
                if needed > left {
                    return Some(Err(DecodeError::Limit { needed }));
                }
                let pixels = pixels.as_chunks::<4>().0.iter().map(|pixel| u32::from_le_bytes(*pixel)).collect();
                Image::new(*width, *height, pixels).map_err(|why| DecodeError::Picture(why.to_string()))
            }
        })
    }

    /// The bytes of the file that `from` names by `path`.
    pub(crate) fn resolve(&self, from: &str, path: &str) -> Option<&[u8]> {
        self.find(from, path).map(Content::bytes)
    }

    fn find(&self, from: &str, path: &str) -> Option<&Content> {
        let folder = from.rfind('/').map_or("", |end| &from[..=end]);
        let wanted = plain(&format!("{folder}{path}"));
        let last = last_part(&wanted);
        let found = |is: &dyn Fn(&str) -> bool| self.0.iter().find(|(name, _)| is(name)).map(|(_, content)| content);
        self.0
            .get(&wanted)
            .or_else(|| found(&|name| name.eq_ignore_ascii_case(&wanted)))
            .or_else(|| found(&|name| last_part(name).eq_ignore_ascii_case(last)))
    }
}

impl Content {
    /// Those of a picture that was decoded are not known.
    fn bytes(&self) -> &[u8] {
        match self {
            Content::Bytes(bytes) => bytes,
            Content::Picture(..) => &[],
        }
    }
}

/// A path without `.` and `..`, as far as it has folders to go back to.
fn plain(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split(['/', '\\']) {
        match part {
            "" | "." => {}
            ".." => drop(parts.pop()),
            part => parts.push(part),
        }
    }
    parts.join("/")
}

fn last_part(path: &str) -> &str {
    path.rsplit('/').next().unwrap_or(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_found_by_path_then_by_name() {
        let mut files = Files::new();
        for name in ["house/house.obj", "house/maps/Wood.PNG", "stone.png", "other/stone.png"] {
            files.add(name, name.as_bytes().to_vec());
        }
        let found = |path| files.resolve("house/house.obj", path).map(|bytes| std::str::from_utf8(bytes).unwrap());
        assert_eq!(found("maps/Wood.PNG"), Some("house/maps/Wood.PNG"));
        assert_eq!(found("./maps\\wood.png"), Some("house/maps/Wood.PNG"));
        assert_eq!(found("../other/stone.png"), Some("other/stone.png"));
        assert_eq!(found("C:/textures/STONE.png"), Some("other/stone.png"));
        assert_eq!(found("../../../stone.png"), Some("stone.png"));
        assert_eq!(found("stones.png"), None);
    }
}
