//! What a surface looks like: the parameters of the thesis's Phong equation (Pineda 2021, section 2.1.1) and those that
//! later effects read. Colours are **linear light**, red, green, blue, 0 to 1; the MTL reader decodes a file's colours,
//! which authoring tools write as they show them (sRGB), once.

/// Index of a material in a scene's list.
pub type MaterialId = u16;

/// A surface's reflection parameters. Construct with [`Material::checked`] where the numbers come from outside.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Material {
    /// Ka: share of the ambient light that comes back.
    pub ambient: [f32; 3],
    /// Kd: matte reflection.
    pub diffuse: [f32; 3],
    /// Ks: highlight.
    pub specular: [f32; 3],
    /// Ke: own light.
    pub emission: [f32; 3],
    /// Tf: light let through, per channel.
    pub transmission: [f32; 3],
    /// Ns, rounded to a whole number, at least 1: the highlight's exponent.
    pub shininess: u32,
    /// d: 1 is solid, 0 is invisible.
    pub opacity: f32,
    /// Ni: optical density.
    pub refraction: f32,
    /// illum: the MTL illumination model, 0 to 10.
    pub illum: u8,
    /// map_Kd: Ka and Kd are multiplied by the colour that each voxel has of its texture. Voxels have one where the scene was
    /// built with the pictures ([`Build::with_textures`](crate::scene::Build::with_textures)) and the mesh has texture
    /// coordinates ([`Mesh::uvs`](crate::Mesh::uvs)).
    pub textured: bool,
}

/// Largest exponent of a highlight; larger ones are drawn with this one.
pub const MAX_SHININESS: u32 = 1_000_000;

/// Why a material is refused: a number that is NaN, infinite or negative.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct MaterialError {
    /// Name of the field, as in [`Material`].
    pub field: &'static str,
}

impl core::fmt::Display for MaterialError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "material field `{}` is not a finite number of 0 or more", self.field)
    }
}

impl core::error::Error for MaterialError {}

impl Material {
    /// The grey that stands in where a mesh names no material.
    pub const GREY: Material = Material {
        ambient: [0.5; 3],
        diffuse: [0.5; 3],
        specular: [0.0; 3],
        emission: [0.0; 3],
        transmission: [1.0; 3],
        shininess: 1,
        opacity: 1.0,
        refraction: 1.0,
        illum: 1,
        textured: false,
    };

    /// The same material with its exponent within 1 to [`MAX_SHININESS`], or which field is not finite or is negative.
    pub fn checked(mut self) -> Result<Material, MaterialError> {
        let ok = |x: &f32| x.is_finite() && *x >= 0.0;
        let triples = [
            ("ambient", self.ambient),
            ("diffuse", self.diffuse),
            ("specular", self.specular),
            ("emission", self.emission),
            ("transmission", self.transmission),
        ];
        for (field, value) in triples {
            if !value.iter().all(ok) {
                return Err(MaterialError { field });
            }
        }
        for (field, value) in [("opacity", self.opacity), ("refraction", self.refraction)] {
            if !ok(&value) {
                return Err(MaterialError { field });
            }
        }
        self.shininess = self.shininess.clamp(1, MAX_SHININESS);
        Ok(self)
    }
}
