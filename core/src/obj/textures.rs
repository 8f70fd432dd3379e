//! The pictures that materials name: found, decoded, laid on their materials.
//!
//! In: a model and a way to find files. Out: a texture a material, and warnings. A picture that is missing or damaged is
//! grey with one warning, however many materials name it; a path is tried relative to its library, then to the OBJ, then as
//! a name beside either, as absolute paths of another machine are.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use std::collections::{HashMap, HashSet};

use super::{Model, Warning};
use crate::material::Material;
use crate::mtl::TextureMap;
use crate::text::quote;
use crate::texture::{Image, Texture, decode};

impl Model {
    /// Reads the textures of the materials that triangles use, and marks these materials
    /// [`textured`](Material::textured). `resolve` gives the bytes of a file by its path (with `/` between folders,
    /// relative to the OBJ), or `None` if there is no such file. What is not as it should be becomes a warning.
    pub fn load_textures(&mut self, mut resolve: impl FnMut(&str) -> Option<Vec<u8>>) {
        let used: HashSet<u16> = self.triangle_materials.iter().copied().collect();
        let mut images = HashMap::new();
        let mut textures = Vec::new();
        for (id, named) in self.materials.iter_mut().enumerate() {
            textures.push(None);
            let Some(map) = named.map_kd.as_ref().filter(|_| used.contains(&(id as u16))) else { continue };
            let mut note = |message| {
                self.warnings.push(Warning { file: map.library.clone(), line: map.line, message });
            };
            let picture = format!("texture {}", quote(&map.path));
            if self.uvs.is_empty() {
                note(format!("{picture} is not drawn: the faces have no texture coordinates (vt)"));
                continue;
            }
            let image = images.entry(map.path.clone()).or_insert_with(|| {
                let image = find(map, &mut resolve);
                image.map_err(|why| note(format!("{picture} {why}; what it would colour is drawn grey"))).ok()
            });
            let material = &mut named.material;
            let Some(image) = image else {
                material.diffuse = Material::GREY.diffuse;
                continue;
            };
            if material.diffuse == [0.0; 3] {
                note(format!("Kd 0 0 0 would make {picture} black; it is drawn as if Kd were 1 1 1"));
                material.diffuse = [1.0; 3];
            }
            material.textured = true;
            textures[id] = Some(Texture::new(image.clone(), map.placement));
        }
        self.textures = textures;
    }
}

/// Decodes the picture, or says why it cannot.
fn find(map: &TextureMap, resolve: &mut impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Arc<Image>, String> {
    let folder = map.library.rfind('/').map_or("", |end| &map.library[..=end]);
    let name = map.path.rsplit('/').next().unwrap_or(&map.path);
    let places = [format!("{folder}{}", map.path), map.path.clone(), format!("{folder}{name}"), name.to_owned()];
    let bytes = places.iter().enumerate().find_map(|(i, place)| {
        // The same place is not asked for twice.
        if places[..i].contains(place) { None } else { resolve(place) }
    });
    let bytes = bytes.ok_or("is not there")?;
    decode(&map.path, &bytes).map(Arc::new).map_err(|why| format!("cannot be read: {why}"))
}
