//! The OBJ importer: any bytes are refused with a line, or make a mesh that is in order.

use voxdag::obj::{self, Model, Warning};

/// Any bytes, UTF-16 and all, with a material library for every path that has an even number of bytes: the same file
/// again, as lines of OBJ are no lines of MTL and some bytes may be both. No panic, results in proportion to the input,
/// and every number in range.
pub fn obj(data: &[u8]) {
    let mut asked = Vec::new();
    let result = obj::import(data, |path| {
        assert!(!asked.contains(&path.to_string()), "asked twice for {path}");
        asked.push(path.to_string());
        // Every path is another library; a file that names many is read in proportion to its size only up to here.
        (path.len().is_multiple_of(2) && asked.len() < 20).then(|| data.to_vec())
    });
    match result {
        Ok(model) => in_order(&model, data.len()),
        Err(error) => check_warning(&error.0, data.len()),
    }
}

/// All that a model promises.
pub(super) fn in_order(model: &Model, input: usize) {
    let triangles = model.triangles.len();
    // A corner takes two bytes at the least, and so does a vertex's every number; polygons that share a vertex repeat it.
    assert!(2 * (triangles + model.faces) <= input, "{triangles} triangles from {input} bytes");
    assert!(model.positions.len() <= 3 * triangles, "vertices that no triangle uses");
    assert!(model.positions.iter().flatten().all(|x| x.is_finite()));
    assert!(model.triangles.iter().flatten().all(|&vertex| (vertex as usize) < model.positions.len()));
    assert!([model.uvs.len(), model.normals.len()].iter().all(|&len| len == 0 || len == triangles));
    assert!(
        model.uvs.iter().flatten().flatten().chain(model.normals.iter().flatten().flatten()).all(|x| !x.is_infinite())
    );

    // Materials: each triangle has one, names are unique and in the order that is said.
    let names: Vec<_> = model.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(model.triangle_materials.len(), triangles);
    assert!(model.triangle_materials.iter().all(|&id| usize::from(id) < names.len()));
    let mut sorted = names.clone();
    sorted.sort_unstable();
    assert!(sorted.is_sorted_by(|a, b| a < b), "two materials of one name");
    assert_eq!(model.name_order.len(), names.len());
    assert!(names.iter().zip(&model.name_order).all(|(name, &rank)| sorted[usize::from(rank)] == *name));
    for named in &model.materials {
        assert_eq!(named.material.checked(), Ok(named.material), "{}", named.name);
        assert!(named.material.illum <= 10);
        for map in [&named.map_kd, &named.map_d].into_iter().flatten() {
            assert!(!map.path.is_empty());
            let map = map.placement;
            assert!(map.scale.iter().chain(&map.offset).chain(&[map.base, map.gain]).all(|x| x.is_finite()));
        }
    }
    if triangles > 0 {
        assert!(model.mesh().validate().is_ok());
    }
    assert!(model.warnings.len() <= 1000);
    model.warnings.iter().for_each(|warning| check_warning(warning, input));
}

/// A warning names a line, and shows no more of it than fits one.
pub(super) fn check_warning(warning: &Warning, input: usize) {
    // Of what a file says at most some pieces of 40 characters are shown, each of which may be escaped.
    assert!(warning.message.len() <= 2000, "{warning}");
    assert!(warning.line >= 1 && warning.line as usize <= input + 1, "{warning}");
    assert!(!warning.to_string().contains('\n') || warning.file.contains('\n'), "{warning}");
}
