//! Runs the real binary in a folder of its own.
#![allow(dead_code)] // each test binary uses its share

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A box with two materials, not square to the axes in one face, so that nothing cancels by symmetry.
pub const OBJ: &str = "\
mtllib box.mtl
v 0 0 0
v 2 0 0
v 2 1 0
v 0 1 0
v 0 0 1
v 2 0 1
v 2 1 1.5
v 0 1 1
usemtl red
f 1 2 3 4
f 5 6 7 8
usemtl blue
f 1 2 6 5
f 4 3 7 8
f 1 4 8 5
f 2 3 7 6
";

pub const MTL: &str = "\
newmtl red
Kd 0.8 0.1 0.1
Ka 0.8 0.1 0.1
newmtl blue
Kd 0.1 0.1 0.8
Ka 0.1 0.1 0.8
Ks 0.5 0.5 0.5
Ns 20
";

/// Of 4 voxels a side of 0.5, away from the world's origin.
pub const GRID: voxdag::Grid = voxdag::Grid { origin: [10.0, 20.0, 30.0], voxel_size: 0.5, resolution: 4 };

/// A folder that disappears with the test.
pub struct Sandbox(tempfile::TempDir);

impl Sandbox {
    /// With `box.obj` and `box.mtl` in it.
    pub fn new() -> Sandbox {
        let sandbox = Sandbox(tempfile::tempdir().unwrap());
        sandbox.write("box.obj", OBJ);
        sandbox.write("box.mtl", MTL);
        sandbox
    }

    pub fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Names of all files, sorted; temporary ones would show here.
    pub fn files(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Writes a scene of some voxels and the materials `grey`, `red, dark` and `blue` that they have.
    pub fn scene(&self, name: &str, grid: voxdag::Grid, voxels: &[([u32; 3], u16)]) {
        use voxdag::materials::AnyMaterials;
        use voxdag::table::{Entry, TableBuf};
        let mut sorted: Vec<_> = voxels.iter().map(|&(v, id)| (voxdag::Morton::encode(v).unwrap(), id)).collect();
        sorted.sort();
        let mut builder = voxdag::build::DagBuilder::new(grid.depth()).unwrap();
        for brick in sorted.chunk_by(|a, b| a.0.0 >> 6 == b.0.0 >> 6) {
            let mask = brick.iter().map(|(v, _)| 1 << (v.0 & 63)).sum();
            builder.push(voxdag::Morton(brick[0].0.0 & !63), mask).unwrap();
        }
        let dag = builder.finish().unwrap();
        let mut table = TableBuf::new(sorted.len() as u64, false).unwrap();
        let entries = sorted.iter().map(|&(v, material)| (v, Entry { material, normal: None }));
        table.insert_all(entries).unwrap();
        let corner = |k: u32| std::array::from_fn(|i| grid.origin[i] + f64::from(k) * grid.voxel_size);
        let parts = voxdag::file::Parts {
            grid,
            bounds: voxdag::grid::Bounds { min: corner(0), max: corner(grid.resolution) },
            up: Default::default(),
            metres_per_unit: 0.0,
            geometry: dag.dag().into(),
            voxel_materials: AnyMaterials::Table(table.as_table()),
            colors: None,
            materials: &[voxdag::Material::GREY; 3],
            names: &["grey", "red, dark", "blue"],
        };
        let words = parts.to_vec().unwrap();
        self.write(name, words.iter().flat_map(|w| w.to_le_bytes()).collect::<Vec<_>>());
    }

    pub fn command(&self, line: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_voxdag"));
        // As a user would call it, not as `cargo run` does.
        command.current_dir(self.0.path()).args(line.split_whitespace()).env_remove("CARGO_MANIFEST_DIR");
        command
    }

    /// Runs `voxdag LINE`, the words apart at spaces.
    pub fn run(&self, line: &str) -> Run {
        Run::from(line, self.command(line).output().unwrap())
    }

    /// The same, and it must succeed.
    pub fn ok(&self, line: &str) -> Run {
        let run = self.run(line);
        assert_eq!(run.code, 0, "voxdag {line}\n{}", run.stderr);
        run
    }
}

/// What came of it.
pub struct Run {
    pub line: String,
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Run {
    fn from(line: &str, output: Output) -> Run {
        Run {
            line: line.to_owned(),
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// The whole of stdout as one JSON value.
    pub fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|e| panic!("voxdag {}: {e}\n{}", self.line, self.stdout))
    }

    /// It failed with `code` and said each of `words`.
    pub fn fails(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "voxdag {}\n{}", self.line, self.stderr);
        assert!(self.stderr.lines().any(|line| line.starts_with("error: ")), "voxdag {}\n{}", self.line, self.stderr);
        assert!(self.stdout.is_empty(), "voxdag {}\n{}", self.line, self.stdout);
        for word in words {
            assert!(self.stderr.contains(word), "voxdag {}: no `{word}` in\n{}", self.line, self.stderr);
        }
    }
}
