//! The pictures that materials name: found and laid on their materials.
//!
//! In: a model and a way to find pictures. Out: the textures of each material, and warnings. A picture that is missing or
//! damaged is one warning, however many materials name it, and what it would colour is grey; a path is tried relative to
//! its library, then to the OBJ, then as a name beside either, as absolute paths of another machine are.

use alloc::borrow::ToOwned;
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec;
use alloc::vec::Vec;
use std::collections::HashMap;

use super::{Model, Warning};
use crate::material::Material;
use crate::mtl::TextureMap;
use crate::text::quote;
use crate::texture::{DecodeError, Image, Maps, Texture};

/// Pictures by the folders of their libraries and their paths from there; `None` for those that cannot be had.
struct Pictures<F> {
    find: F,
    known: HashMap<(String, String), Option<Arc<Image>>>,
    /// Bytes that pictures may still take.
    left: u64,
}

impl Model {
    /// Reads the textures of the materials that triangles use, and marks materials with a colour of their own
    /// [`textured`](Material::textured). `find` gives a picture by its path (with `/` between folders, relative to the OBJ)
    /// in at most so many bytes, or `None` if there is no such file: [`decode`](crate::texture) with the feature
    /// `images`. What is not as it should be becomes a warning.
    ///
    /// Err: the bytes that pictures take at least, if that is more than `limit`; then there are no textures.
    pub fn load_textures(
        &mut self,
        find: impl FnMut(&str, u64) -> Option<Result<Image, DecodeError>>,
        limit: u64,
    ) -> Result<(), u64> {
        let laid = self.laid();
        let mut pictures = Pictures { find, known: HashMap::new(), left: limit };
        let mut textures = Vec::new();
        for (named, &laid) in self.materials.iter_mut().zip(&laid) {
            let (mut diffuse, mut dissolve) = (None, None);
            let mut note = |map: &TextureMap, message| {
                self.warnings.push(Warning { file: map.library.clone(), line: map.line, message });
            };
            let is_used = laid != [0, 0];
            if let Some(map) = named.map_kd.clone().filter(|_| is_used) {
                let found = pictures.texture(&map, laid, "what it would colour is drawn grey", &mut note);
                diffuse = match found.map_err(|needed| needed.saturating_add(limit - pictures.left))? {
                    Found::Texture(texture) => {
                        if named.material.diffuse == [0.0; 3] {
                            let path = quote(&map.path);
                            note(&map, format!("Kd 0 0 0 would make texture {path} black; Kd 1 1 1 is used instead"));
                            named.set_diffuse([1.0; 3]);
                        }
                        named.material.textured = true;
                        Some(texture)
                    }
                    Found::Lost => {
                        named.set_diffuse(Material::GREY.diffuse);
                        None
                    }
                    Found::Useless => None,
                };
            }
            if let Some(map) = named.map_d.as_ref().filter(|_| is_used) {
                let found = pictures.texture(map, laid, "nothing is cut out of its surfaces", &mut note);
                if let Found::Texture(texture) = found.map_err(|needed| needed.saturating_add(limit - pictures.left))? {
                    dissolve = Some(texture);
                }
            }
            let needed = Maps::bytes_for(diffuse.as_ref(), dissolve.as_ref());
            let over = limit.saturating_sub(pictures.left).saturating_add(needed);
            pictures.left = pictures.left.checked_sub(needed).ok_or(over)?;
            textures.push(Maps::new(diffuse, dissolve).map_err(|_| over)?);
        }
        self.textures = textures;
        Ok(())
    }

    /// How many triangles of each material have texture coordinates, and how many do not.
    fn laid(&self) -> Vec<[usize; 2]> {
        let mut laid = vec![[0; 2]; self.materials.len()];
        for (triangle, &id) in self.triangle_materials.iter().enumerate() {
            let is_number = |corners: &[[f32; 2]; 3]| corners.as_flattened().iter().all(|x| x.is_finite());
            let is_laid = self.uvs.get(triangle).is_some_and(is_number);
            laid[usize::from(id)][usize::from(!is_laid)] += 1;
        }
        laid
    }
}

/// What became of a texture.
enum Found {
    Texture(Texture),
    /// Its picture cannot be had.
    Lost,
    /// There are no coordinates to draw it by.
    Useless,
}

impl<F: FnMut(&str, u64) -> Option<Result<Image, DecodeError>>> Pictures<F> {
    /// The texture of a statement; a picture that cannot be had is noted once, with what comes of it. Err: the bytes that its
    /// picture takes, if they are too many.
    fn texture(
        &mut self,
        map: &TextureMap,
        [laid, others]: [usize; 2],
        instead: &str,
        note: &mut impl FnMut(&TextureMap, String),
    ) -> Result<Found, u64> {
        let picture = format!("texture {}", quote(&map.path));
        if laid == 0 {
            note(map, format!("{picture} is not used: the faces have no texture coordinates (vt)"));
            return Ok(Found::Useless);
        }
        let key = (map.folder().to_owned(), map.path.clone());
        if !self.known.contains_key(&key) {
            let image = match self.find(map) {
                Ok(image) => {
                    self.left = self.left.saturating_sub(image.bytes());
                    Some(Arc::new(image))
                }
                Err(DecodeError::Limit { needed }) => return Err(needed),
                Err(DecodeError::Picture(why)) => {
                    note(map, format!("{picture} {why}; {instead}"));
                    None
                }
            };
            self.known.insert(key.clone(), image);
        }
        Ok(match &self.known[&key] {
            Some(image) => {
                if others > 0 {
                    let all = laid + others;
                    let why = "they have no texture coordinates (vt)";
                    note(map, format!("{picture} is not used on {others} of {all} triangles: {why}"));
                }
                Found::Texture(Texture::new(image.clone(), map.placement))
            }
            None => Found::Lost,
        })
    }

    /// Finds a picture, or says why it cannot: why the first that is there cannot be read, if no other can.
    fn find(&mut self, map: &TextureMap) -> Result<Image, DecodeError> {
        let mut why = None;
        for place in map.places() {
            match (self.find)(&place, self.left) {
                Some(Err(DecodeError::Picture(cause))) => _ = why.get_or_insert(format!("cannot be read: {cause}")),
                Some(found) => return found,
                None => {}
            }
        }
        Err(why.unwrap_or_else(|| "is not there".to_owned()).into())
    }
}
