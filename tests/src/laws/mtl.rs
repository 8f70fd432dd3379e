//! The MTL importer: no library is refused, and every material is one that can be drawn.

use voxdag::mtl::NamedMaterial;
use voxdag::obj;

/// Any bytes as the only library of a small OBJ: they lead to warnings at the most.
pub fn mtl(data: &[u8]) {
    const OBJ: &[u8] = b"mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n";
    let model = obj::import(OBJ, |path| (path == "a.mtl").then(|| data.to_vec()))
        .unwrap_or_else(|error| panic!("a library was refused: {error}"));
    super::obj::in_order(&model, OBJ.len() + data.len());
    assert_eq!(model.triangles.len(), 1);

    // The face has the material of its name; it is grey where nothing defines it.
    let used = &model.materials[usize::from(model.triangle_materials[0])];
    assert_eq!(used.name, "red");

    // A material takes a line of eight bytes or more; warnings and names are no longer than what they speak of.
    assert!(8 * (model.materials.len() - 1) <= data.len() + 8, "{} materials", model.materials.len());
    let paths =
        |m: &NamedMaterial| [&m.map_kd, &m.map_d].into_iter().flatten().map(|map| map.path.len()).sum::<usize>();
    let texts: usize = model.materials.iter().map(|m| m.name.len() + paths(m)).sum();
    // Latin-1 takes two bytes a character in UTF-8, and a damaged UTF-16 three.
    assert!(texts <= 3 + 3 * data.len(), "{texts} bytes of names");

    // Read a second time it says the same.
    let again = obj::import(OBJ, |_| Some(data.to_vec())).expect("it was read before");
    assert!(again.materials == model.materials && again.warnings == model.warnings);
}
