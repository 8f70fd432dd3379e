//! Wavefront OBJ: polygons and their materials.
//!
//! In: the bytes of a file and a way to find its material libraries; no I/O here. Out: triangles, one material each,
//! and warnings. The way: the front checks the text and rewrites it plainly, tobj parses that, polygons are cut by
//! [`triangulate`](crate::triangulate), libraries are read by [`mtl`](crate::mtl).
//!
//! tobj's material hook hands the front's own material numbers back. The libraries are read beside it: the hook looks a
//! name up when its `usemtl` comes, so a `mtllib` further down would be lost; it takes a whole line for one file; and it
//! gives no lines for warnings.

mod front;
mod textures;

use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;
use std::collections::{HashMap, HashSet};
use std::io::Read;

use crate::Mesh;
use crate::material::Material;
use crate::mtl::{MOST_MATERIALS, Materials, NamedMaterial};
use crate::text::{Notes, decode, path, quote};
use crate::texture::Maps;
use crate::triangulate::Triangulator;

pub use crate::text::Note as Warning;

/// A scene as an OBJ and its libraries describe it.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// World positions; those that polygons of several materials share are repeated.
    pub positions: Vec<[f64; 3]>,
    /// Three indices into `positions` each, in the orientation of their polygon and in the order of the file.
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` per triangle.
    pub triangle_materials: Vec<u16>,
    /// Place of each material among the names in byte order.
    pub name_order: Vec<u16>,
    /// Texture coordinates per triangle and corner, NaN where the file gives none; empty if it gives none at all.
    pub uvs: Vec<[[f32; 2]; 3]>,
    /// Normals per triangle and corner, NaN where the file gives none; empty if it gives none at all.
    pub normals: Vec<[[f32; 3]; 3]>,
    /// The materials of all libraries, used or not, in their order; then a grey one for each name that faces use and no
    /// library defines, in byte order; then, if there are faces without a material, a grey `default` (unless something
    /// is called that already). So no id depends on the order of the faces. Names are unique.
    pub materials: Vec<NamedMaterial>,
    /// Their textures, by id; empty until [`Model::load_textures`] has read them.
    pub textures: Vec<Maps>,
    /// Polygons read.
    pub faces: usize,
    /// What was not as it should be and did not stop the import.
    pub warnings: Vec<Warning>,
}

impl Model {
    /// The triangles as voxelisation reads them. (A file without polygons gives a mesh without triangles.)
    pub fn mesh(&self) -> Mesh<'_> {
        Mesh {
            positions: &self.positions,
            triangles: &self.triangles,
            materials: &self.triangle_materials,
            name_order: &self.name_order,
            uvs: &self.uvs,
            normals: &self.normals,
        }
    }

    /// The parameters of the materials, by id, for a scene that has colours of voxels or has none: without, no material is
    /// [`textured`](Material::textured), as where all that a texture would colour is cut out or belongs to others.
    pub fn palette(&self, has_colors: bool) -> impl Iterator<Item = Material> {
        let materials = self.materials.iter().map(|named| named.material);
        materials.map(move |material| Material { textured: has_colors && material.textured, ..material })
    }
}

/// Why a file is refused; says where, like a [`Warning`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ImportError(pub Warning);

impl fmt::Display for ImportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl core::error::Error for ImportError {}

/// The name of the material of faces that have none.
pub const DEFAULT_MATERIAL: &str = "default";

/// Reads an OBJ. `resolve` gives the bytes of a material library by the path in the file (with `/` between folders,
/// relative to the OBJ), or `None` if there is no such file; it is asked once per path.
///
/// Refused are files whose geometry is wrong: numbers that are not finite, indices out of range, faces with fewer than
/// three corners, more than 65,535 materials. Everything else, from a missing library on, is a warning. Memory is in
/// proportion to the input; polygons with n corners take O(n^2) time.
///
/// ```
/// let obj = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n";
/// let model = voxdag::obj::import(obj, |path| (path == "a.mtl").then(|| b"newmtl red\nKd 1 0 0\n".to_vec()))?;
/// assert_eq!((model.faces, model.triangles.len()), (1, 2));
/// assert_eq!(model.materials[0].material.diffuse, [1.0, 0.0, 0.0]);
/// # Ok::<(), voxdag::obj::ImportError>(())
/// ```
pub fn import(obj: &[u8], mut resolve: impl FnMut(&str) -> Option<Vec<u8>>) -> Result<Model, ImportError> {
    let mut notes = Notes::default();
    let checked = front::check(&decode(obj), &mut notes)?;

    let mut materials = Materials::default();
    read_libraries(&checked.libraries, &mut resolve, &mut materials, &mut notes)?;
    let ids = assign_ids(&checked, &mut materials, &mut notes)?;
    let parsed = parse(&checked)?;
    let mut model = assemble(&parsed, &ids)?;

    model.name_order = ranks(&materials.list);
    model.materials = materials.list;
    model.faces = checked.polygons;
    model.warnings = notes.into_list();
    Ok(model)
}

fn error(line: u32, message: String) -> ImportError {
    ImportError(Warning { file: String::new(), line, message })
}

/// Reads what the `mtllib` statements name.
fn read_libraries(
    libraries: &[(u32, String)],
    resolve: &mut impl FnMut(&str) -> Option<Vec<u8>>,
    materials: &mut Materials,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let mut asked = HashMap::new();
    // Whether the path names a file; each is asked for and read only once.
    let mut found = |path: String, notes: &mut Notes| -> Result<bool, ImportError> {
        if let Some(&found) = asked.get(&path) {
            return Ok(found);
        }
        let bytes = resolve(&path);
        if let Some(bytes) = &bytes {
            materials.read(&path, bytes, notes).map_err(|line| {
                let message = format!("more than {MOST_MATERIALS} materials; merge or delete some");
                ImportError(Warning { file: path.clone(), line, message })
            })?;
        }
        asked.insert(path, bytes.is_some());
        Ok(bytes.is_some())
    };
    let mut repeated = HashSet::new();
    for (line, named) in libraries {
        if !repeated.insert(named) {
            continue;
        }
        // The whole line is one name, if there is such a file; else a list, in which `\ ` is a space within a name.
        if found(path(named), notes)? {
            continue;
        }
        let mut missing = Vec::new();
        let mut any = false;
        let list = split_list(named);
        for name in &list {
            if list.len() > 1 && found(path(name), notes)? {
                any = true;
            } else {
                missing.push(path(name));
            }
        }
        if !any {
            missing = Vec::from([path(named)]);
        }
        for name in missing {
            let name = quote(&name);
            notes.push("", *line, format!("material library {name} is not there; what it would define is drawn grey"));
        }
    }
    Ok(())
}

/// The names in a list that is separated by white space and ends at a `#`; `\` before white space keeps it in the name.
fn split_list(list: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut name = String::new();
    let mut characters = list.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '\\' if characters.peek().is_some_and(char::is_ascii_whitespace) => name.extend(characters.next()),
            '#' if name.is_empty() => break,
            c if !c.is_ascii_whitespace() => name.push(c),
            _ if !name.is_empty() => names.push(core::mem::take(&mut name)),
            _ => {}
        }
    }
    if !name.is_empty() {
        names.push(name);
    }
    names
}

/// Material ids of the front's names.
struct Ids {
    /// By place in the front's names.
    named: Vec<u16>,
    /// For faces without a material.
    bare: u16,
}

/// Adds a grey material for every name that no library defines, and one for faces without.
fn assign_ids(checked: &front::Checked, materials: &mut Materials, notes: &mut Notes) -> Result<Ids, ImportError> {
    let too_many = |line: u32| error(line, format!("more than {MOST_MATERIALS} materials; merge or delete some"));
    let mut undefined: Vec<&front::Used> = checked.names.iter().filter(|n| materials.id(&n.name).is_none()).collect();
    for used in &undefined {
        let name = quote(&used.name);
        notes.push("", used.line, format!("material {name} is not defined by any library; its faces are drawn grey"));
    }
    undefined.sort_by(|a, b| a.name.cmp(&b.name));
    for used in undefined {
        materials.push_grey(&used.name).ok_or_else(|| too_many(used.line))?;
    }
    let mut bare = 0;
    if let Some(line) = checked.bare {
        let message = format!("faces without a material; they are drawn with the material \"{DEFAULT_MATERIAL}\"");
        notes.push("", line, message);
        bare = match materials.id(DEFAULT_MATERIAL) {
            Some(id) => id,
            None => materials.push_grey(DEFAULT_MATERIAL).ok_or_else(|| too_many(line))?,
        };
    }
    let named = checked.names.iter().filter_map(|used| materials.id(&used.name)).collect();
    Ok(Ids { named, bare })
}

/// Place of each name in byte order.
fn ranks(materials: &[NamedMaterial]) -> Vec<u16> {
    let mut order: Vec<u16> = (0..materials.len() as u16).collect();
    order.sort_by(|&a, &b| materials[usize::from(a)].name.cmp(&materials[usize::from(b)].name));
    let mut ranks = Vec::from_iter(order.iter().map(|_| 0));
    for (rank, id) in order.into_iter().enumerate() {
        ranks[usize::from(id)] = rank as u16;
    }
    ranks
}

/// Lets tobj read what the front wrote. A model of its answer holds consecutive faces of one material.
fn parse(checked: &front::Checked) -> Result<Vec<tobj::Model>, ImportError> {
    // Polygons stay whole, and keep an index per attribute; the front let no points or lines through.
    let options = tobj::LoadOptions::default();
    let hook = b"mtllib numbers\n";
    let mut reader = hook.chain(checked.vertices.as_bytes()).chain(checked.faces.as_bytes());
    let numbers = |_: &std::path::Path| -> tobj::MTLLoadResult {
        let places: HashMap<_, _> = (0..checked.names.len()).map(|place| (place.to_string(), place)).collect();
        Ok((Vec::new(), places))
    };
    let (models, _) = tobj::load_obj_buf(&mut reader, &options, numbers)
        .map_err(|e| error(1, format!("the file passed every check, but not the parser ({e}); please report this")))?;
    Ok(models)
}

/// Cuts the polygons and joins the models.
fn assemble(parsed: &[tobj::Model], ids: &Ids) -> Result<Model, ImportError> {
    let mut model = Model::default();
    let mut triangulator = Triangulator::default();
    let mut polygon = Vec::new();
    let (mut any_uv, mut any_normal) = (false, false);
    for tobj::Model { mesh, .. } in parsed {
        let id = mesh.material_id.and_then(|place| ids.named.get(place)).copied().unwrap_or(ids.bare);
        let base = u32::try_from(model.positions.len() + mesh.positions.len() / 3)
            .map(|_| model.positions.len() as u32)
            .map_err(|_| error(1, "more than 2^32 vertices in use; split the file".to_string()))?;
        model.positions.extend(mesh.positions.as_chunks().0);
        let uvs = mesh.texcoords.as_chunks::<2>().0;
        let normals = mesh.normals.as_chunks::<3>().0;

        let arities = mesh.face_arities.iter().map(|&arity| arity as usize);
        let triangles = if mesh.face_arities.is_empty() { mesh.indices.len() / 3 } else { 0 };
        let mut first = 0;
        for arity in arities.chain(core::iter::repeat_n(3, triangles)) {
            let face = first..first + arity;
            first += arity;
            let indices = &mesh.indices[face.clone()];
            // None in a file without any.
            let (uv, normal) = (mesh.texcoord_indices.get(face.clone()), mesh.normal_indices.get(face));
            polygon.clear();
            polygon.extend(indices.iter().map(|&index| model.positions[(base + index) as usize]));
            let cut = triangulator.triangulate(&polygon);
            for &corners in cut.map_err(|bytes| error(1, format!("no memory: {bytes} bytes could not be had")))? {
                let corners = corners.map(|corner| corner as usize);
                model.triangles.push(corners.map(|corner| base + indices[corner]));
                model.triangle_materials.push(id);
                if let Some(uv) = uv {
                    let uv = corners.map(|corner| uvs[uv[corner] as usize].map(|x| x as f32));
                    any_uv |= uv.iter().any(|uv| !uv[0].is_nan());
                    model.uvs.push(uv);
                }
                if let Some(normal) = normal {
                    let normal = corners.map(|corner| normals[normal[corner] as usize].map(|x| x as f32));
                    any_normal |= normal.iter().any(|normal| !normal[0].is_nan());
                    model.normals.push(normal);
                }
            }
        }
    }
    if !any_uv {
        model.uvs = Vec::new();
    }
    if !any_normal {
        model.normals = Vec::new();
    }
    Ok(model)
}
