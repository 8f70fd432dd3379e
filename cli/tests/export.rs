//! `voxdag export`: what was written is read back by small readers of this file's own.

mod common;
use common::{GRID, Sandbox};
use voxdag::Geometry;
use voxdag::build::DagBuilder;
use voxdag::file::Parts;
use voxdag::grid::{Bounds, UpAxis};
use voxdag::materials::{AnyMaterials, Materials, Single};
use voxdag::table::TableBuf;
use voxdag::{Grid, Material, Morton};

fn words(s: &Sandbox, name: &str) -> Vec<u32> {
    s.read(name).chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// A box, and a sparse scene that reaches into all corners of a cube whose side suits no power of two.
fn scenes() -> Sandbox {
    let s = Sandbox::new();
    s.ok("build box.obj -o box.vxd -r 70");
    let mut voxels = vec![([148, 1, 2], 2), ([5, 64, 63], 1), ([5, 65, 63], 0), ([5, 63, 63], 2)];
    for corner in 0..8u32 {
        voxels.push(([0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { 0 } else { 149 }), 1));
    }
    s.scene("sparse.vxd", Grid { origin: [-1.25, 0.1, 1e-7], voxel_size: 0.03, resolution: 150 }, &voxels);
    s.scene("small.vxd", GRID, &[([1, 2, 3], 1), ([3, 0, 1], 2)]);
    s.scene("point.vxd", Grid { resolution: 1, ..GRID }, &[([0, 0, 0], 1)]);
    s
}

const NAMES: [&str; 4] = ["box", "sparse", "small", "point"];

#[test]
fn xyz_and_npy_list_the_voxels_in_morton_order() {
    let s = scenes();
    for name in NAMES {
        let words = words(&s, &format!("{name}.vxd"));
        let scene = voxdag::file::read(&words).unwrap();
        let expected: Vec<[u32; 4]> = scene
            .geometry
            .voxels()
            .map(|v| {
                let [x, y, z] = v.decode();
                [x, y, z, scene.materials.id(v).into()]
            })
            .collect();
        let report = s.ok(&format!("export {name}.vxd --to xyz -o out.xyz --json")).json();
        let text = String::from_utf8(s.read("out.xyz")).unwrap();
        let lines: Vec<Vec<u32>> =
            text.lines().map(|line| line.split(' ').map(|n| n.parse().unwrap()).collect()).collect();
        assert!(lines == expected, "{name}");
        assert_eq!(report["voxels"], expected.len());
        assert_eq!(report["bytes"], text.len());

        s.ok(&format!("export {name}.vxd --to npy -o out.npy"));
        let file = s.read("out.npy");
        assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
        let data = 10 + usize::from(u16::from_le_bytes([file[8], file[9]]));
        let header = std::str::from_utf8(&file[10..data]).unwrap();
        let shape = format!("{{'descr': '<u4', 'fortran_order': False, 'shape': ({}, 4), }}", expected.len());
        assert!(data.is_multiple_of(64) && header.ends_with('\n'));
        assert_eq!(header.trim_end(), shape);
        let rows: Vec<[u32; 4]> = file[data..]
            .chunks(16)
            .map(|row| std::array::from_fn(|i| u32::from_le_bytes(row[4 * i..][..4].try_into().unwrap())))
            .collect();
        assert!(rows == expected, "{name}");
    }
}

#[test]
fn binvox_unpacks_to_the_same_voxels_at_the_same_place() {
    let s = scenes();
    for name in NAMES {
        let words = words(&s, &format!("{name}.vxd"));
        let scene = voxdag::file::read(&words).unwrap();
        let (grid, n) = (scene.grid, scene.grid.resolution);
        s.ok(&format!("export {name}.vxd --to binvox -o out.binvox"));
        let file = s.read("out.binvox");
        let data = file.windows(5).position(|w| w == b"data\n").unwrap() + 5;
        let header: Vec<_> = std::str::from_utf8(&file[..data]).unwrap().lines().collect();
        assert_eq!((header[0], header[1], header[4]), ("#binvox 1", &*format!("dim {n} {n} {n}"), "data"));
        let numbers = |line: &str, key: &str| -> Vec<f64> {
            line.strip_prefix(key).unwrap().split_whitespace().map(|x| x.parse().unwrap()).collect()
        };
        assert_eq!(numbers(header[2], "translate "), grid.origin);
        assert_eq!(numbers(header[3], "scale "), [f64::from(n) * grid.voxel_size]);

        let mut cells = Vec::new();
        for run in file[data..].chunks(2) {
            assert!(run[0] <= 1 && run[1] > 0, "{run:?}");
            cells.extend(std::iter::repeat_n(run[0] == 1, run[1].into()));
        }
        assert_eq!(cells.len(), (n as usize).pow(3), "{name}");
        let mut cell = cells.into_iter();
        for x in 0..n {
            for z in 0..n {
                for y in 0..n {
                    let voxel = Morton::encode([x, y, z]).unwrap();
                    assert_eq!(cell.next(), Some(scene.geometry.contains(voxel)), "{name} {x} {y} {z}");
                }
            }
        }
    }
}

#[test]
fn stdout_gets_the_same_bytes_as_a_file() {
    let s = scenes();
    for format in ["binvox", "xyz", "npy"] {
        s.ok(&format!("export box.vxd --to {format} -o out.{format}"));
        for dash in ["", "-o -"] {
            let output = s.command(&format!("export box.vxd --to {format} {dash}")).output().unwrap();
            assert!(output.status.success() && output.stdout == s.read(&format!("out.{format}")), "{format} {dash}");
        }
    }
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let s = scenes();
    let most = Grid { resolution: 4097, ..GRID };
    s.scene("large.vxd", most, &[([4096, 0, 17], 1)]);
    let before = s.files();
    s.run("export large.vxd --to binvox -o out.binvox").fails(4, &["4097", "4096", "hint:"]);
    s.run("export box.vxd --to binvox -o out.xyz").fails(2, &["out.xyz", ".binvox"]);
    s.run("export box.vxd --to vox -o out.vox").fails(2, &["binvox", "xyz", "npy"]);
    s.run("export box.vxd").fails(2, &["--to"]);
    s.run("export box.vxd --to xyz --json").fails(2, &["-o"]);
    s.run("export box.obj --to xyz -o out.xyz").fails(3, &["not a voxdag scene"]);
    assert_eq!(s.files(), before);
    assert_eq!(s.ok("export large.vxd --to xyz").stdout, "4096 0 17 1\n");
}

/// Writes the full cube of 2^63 voxels into a file of less than two kilobytes, with one material or an empty table.
fn fullest_cube(s: &Sandbox, name: &str, table: bool) {
    let mut cube = DagBuilder::new(2).unwrap();
    cube.push(Morton(0), u64::MAX).unwrap();
    let mut cube = cube.finish().unwrap();
    for depth in 3..=21 {
        let mut builder = DagBuilder::new(depth).unwrap();
        (0..8).for_each(|octant| builder.append(Morton(octant << (3 * (depth - 1))), &cube.dag()).unwrap());
        cube = builder.finish().unwrap();
    }
    let entries = TableBuf::new(1, false).unwrap();
    let grid = Grid { resolution: 1 << 21, ..GRID };
    let parts = Parts {
        grid,
        bounds: Bounds { min: grid.origin, max: grid.to_world([f64::from(1 << 21); 3]) },
        up: UpAxis::Y,
        metres_per_unit: 0.0,
        geometry: cube.dag().into(),
        voxel_materials: if table { AnyMaterials::Table(entries.as_table()) } else { AnyMaterials::Single(Single(0)) },
        colors: None,
        materials: &[Material::GREY],
        names: &["grey"],
    };
    let words = parts.to_vec().unwrap();
    assert!(words.len() < 400, "{} words", words.len());
    s.write(name, words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<_>>());
}

#[test]
fn d05_the_fullest_cube_is_counted_and_refused_in_no_time() {
    let s = Sandbox::new();
    fullest_cube(&s, "full.vxd", false);
    fullest_cube(&s, "table.vxd", true);
    assert_eq!(s.ok("info full.vxd --json").json()["voxels"], 1u64 << 63);
    s.ok("verify full.vxd");
    s.run("verify table.vxd").fails(3, &["9223372036854775808 voxels, but 0 entries"]);
    let before = s.files();
    for to in ["npy -o out.npy", "xyz -o out.xyz", "npy -o -"] {
        s.run(&format!("export full.vxd --to {to}")).fails(4, &["9,223,372,036,854,775,808 voxels", "hint:"]);
    }
    s.run("export full.vxd --to binvox -o out.binvox").fails(4, &["2097152", "4096"]);
    for subject in ["materials", "ranks"] {
        for scene in ["full.vxd", "table.vxd"] {
            s.run(&format!("bench {subject} {scene} --size 4x4 --repeat 1"))
                .fails(4, &["9,223,372,036,854,775,808 voxels"]);
        }
    }
    assert_eq!(s.files(), before);
}

#[cfg(unix)]
#[test]
fn a_reader_that_has_seen_enough_is_no_failure() {
    let s = scenes();
    let program = env!("CARGO_BIN_EXE_voxdag");
    let line = format!("{program} export box.vxd --to xyz | head -n 1; echo ${{PIPESTATUS[0]}}");
    let output = std::process::Command::new("bash").args(["-c", &line]).current_dir(s.path("")).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout).lines().nth(1), Some("0"));
}
