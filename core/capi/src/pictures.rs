//! The pictures of textures, each kept once however many materials show it.

use std::sync::Arc;

use voxdag::scene::SceneError;
use voxdag::texture::{Image, ImageError, Maps, Placement, Texture};

use crate::border::Caller;
use crate::error::Failure;
use crate::mesh::{VoxdagMesh, VoxdagTexture, list};

/// Pictures that were read.
pub(crate) struct Pictures {
    known: Vec<(VoxdagTexture, Arc<Image>)>,
    /// Most bytes that they may take, and those that they do.
    limit: u64,
    pub bytes: u64,
}

impl Pictures {
    pub fn new(limit: u64) -> Pictures {
        Pictures { known: Vec::new(), limit, bytes: 0 }
    }

    /// The textures of all materials.
    pub fn maps(&mut self, caller: &Caller, mesh: &VoxdagMesh) -> Result<Vec<Maps>, Failure> {
        let count = mesh.material_count;
        let diffuse = caller.optional("mesh.textures", mesh.textures, count)?.unwrap_or(&[]);
        let dissolve = caller.optional("mesh.cutouts", mesh.cutouts, count)?.unwrap_or(&[]);
        let mut maps = list(diffuse.len().max(dissolve.len()))?;
        for material in 0..diffuse.len().max(dissolve.len()) {
            let mut of = |textures: &[VoxdagTexture]| match textures.get(material) {
                Some(texture) if !texture.pixels.is_null() => self.texture(caller, texture, material as u64).map(Some),
                _ => Ok(None),
            };
            let (color, cut) = (of(diffuse)?, of(dissolve)?);
            self.bytes = self.bytes.saturating_add(Maps::bytes_for(color.as_ref(), cut.as_ref()));
            if self.bytes > self.limit {
                return Err(Failure::Memory { needed: self.bytes });
            }
            maps.push(Maps::new(color, cut).map_err(|_| Failure::Memory { needed: self.bytes })?);
        }
        Ok(maps)
    }

    fn texture(&mut self, caller: &Caller, texture: &VoxdagTexture, index: u64) -> Result<Texture, Failure> {
        let VoxdagTexture { scale: [su, sv], offset: [ou, ov], base, gain, clamp, .. } = *texture;
        let placement = Placement { scale: [su, sv, 1.0], offset: [ou, ov, 0.0], base, gain, clamp: clamp != 0 };
        let numbers = [su, sv, ou, ov, base, gain];
        if !numbers.iter().all(|number| number.is_finite()) {
            return Err(Failure::Texture { index });
        }
        Ok(Texture::new(self.image(caller, texture, index)?, placement))
    }

    /// The picture of a texture, and its halves.
    fn image(&mut self, caller: &Caller, texture: &VoxdagTexture, index: u64) -> Result<Arc<Image>, Failure> {
        let VoxdagTexture { pixels, width, height, .. } = *texture;
        let same = |known: &VoxdagTexture| (known.pixels, known.width, known.height) == (pixels, width, height);
        if let Some((_, image)) = self.known.iter().find(|(known, _)| same(known)) {
            return Ok(image.clone());
        }
        let count = u64::from(width) * u64::from(height);
        if count == 0 {
            return Err(Failure::Texture { index });
        }
        // The halves take less than half as much again.
        let needed = self.bytes.saturating_add(count.saturating_mul(6));
        if needed > self.limit {
            return Err(Failure::Memory { needed });
        }
        let count = usize::try_from(count).map_err(|_| Failure::Memory { needed })?;
        let bytes = caller.slice("mesh.textures.pixels", pixels.cast::<[u8; 4]>(), count)?;
        let mut words = list(count)?;
        words.extend(bytes.iter().map(|pixel| u32::from_le_bytes(*pixel)));
        let image = Image::new(width, height, words).map_err(|error| match error {
            ImageError::Memory { bytes } => Failure::Memory { needed: bytes },
            ImageError::Size { .. } => Failure::Texture { index },
        })?;
        self.bytes += image.bytes();
        self.known.try_reserve(1).map_err(|_| Failure::Memory { needed })?;
        let image = Arc::new(image);
        self.known.push((*texture, image.clone()));
        Ok(image)
    }

    /// An error of a build that takes its memory beside the pictures.
    pub fn beside(&self, error: SceneError) -> Failure {
        Failure::Build(match error {
            SceneError::Limit { needed, enough, limit, coarser } => SceneError::Limit {
                needed: needed.saturating_add(self.bytes),
                enough: enough.saturating_add(self.bytes),
                limit: limit.saturating_add(self.bytes),
                coarser,
            },
            error => error,
        })
    }
}
