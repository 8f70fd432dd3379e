//! The report: the tables as Markdown, CSV and JSON, what they were measured on, and how far all representations agree.

use serde::Serialize;

use super::table::{Cell, Row, Table, escaped};
use crate::error::{Error, Kind, Result};
use crate::report::{grouped, visible};

/// Everything that was measured.
#[derive(Serialize)]
pub struct Report {
    /// As it was typed.
    command: String,
    machine: Machine,
    pub runs: u32,
    tables: Vec<Table>,
    pub agreements: Vec<Agreement>,
    /// Pictures by scene: name of the scene, of the configuration, and the file.
    #[serde(skip)]
    pub pictures: Vec<[String; 3]>,
}

#[derive(Serialize)]
struct Machine {
    os: &'static str,
    architecture: &'static str,
    /// Its name, where the system says it.
    processor: Option<String>,
    threads: usize,
    version: &'static str,
}

/// Whether equal data gave equal pictures.
#[derive(Serialize)]
pub struct Agreement {
    pub scene: String,
    pub resolution: u32,
    /// Of layout, representation and normals.
    pub combinations: u32,
    pub equal: bool,
}

const TABLES: [(&str, &str, &str, usize, &str); 15] = [
    (
        "5.1",
        "Triangles and materials of the scenes",
        "number",
        0,
        "In brackets, here and below: the thesis's figures, for its own versions of the scenes, on its own machine.",
    ),
    (
        "5.2a",
        "Memory of the geometry, by the thesis's accounting",
        "KB",
        0,
        "Masks and pointers of 8 bytes. The sum that Williams quotes reads its table of words a level from the wrong end.",
    ),
    (
        "5.2b",
        "Memory of the materials, by the thesis's accounting",
        "MB",
        1,
        "Bytes of keys, normals and indices alone, as if the hash table had no empty slot. What this program holds is in \
         table 5.9.",
    ),
    (
        "5.3",
        "Build times of the hash table's side",
        "ms",
        1,
        "This program voxelises and reduces part by part: voxelization includes reducing each part to a DAG, the row DAG is \
         joining the parts. The table keeps a normal with each voxel.",
    ),
    (
        "5.4",
        "Build times of the moxel side",
        "ms",
        1,
        "Both sides have the same voxeliser here. The moxel table is written in one pass over the voxels in Morton order; \
         Williams asks every voxel of the grid whether it is filled.",
    ),
    ("5.5", "Render times with stored normals, 5 samples a pixel", "ms", 1, ""),
    ("5.6", "Memory of the hash table without normals, by the thesis's accounting", "MB", 1, ""),
    (
        "5.7",
        "Render times with calculated normals, 5 samples a pixel",
        "ms",
        1,
        "The first row is the thesis's method (`ernerfeldt2`), the others are this program's own.",
    ),
    ("5.8", "Render times by supersampling", "ms", 1, "Adaptive supersampling is this program's own."),
    ("5.8b", "Rays of supersampling, of those of 16 samples everywhere", "%", 1, ""),
    ("5.9a", "What this program holds: every layout and representation", "KB", 1, "The thesis has no such table."),
    ("5.9b", "The same by voxel", "bits", 3, ""),
    ("5.10", "Build times of this program's own representations", "ms", 1, ""),
    (
        "5.11",
        "Look-ups at the voxels of a picture",
        "ns",
        1,
        "Of one thread, in the order of the pixels. Those by rank go by prefix counts.",
    ),
    ("5.12", "Filled voxels", "number", 0, "Every voxel that a triangle touches."),
];

/// Pairs of pictures, as the thesis has them.
const FIGURES: [(&str, &str, &str); 3] = [
    ("Figures 5.1 and 5.4: 16 samples everywhere, and on the nearer half", "16-samples", "near"),
    ("Figure 5.2: stored and calculated normals", "stored-normals", "calculated-normals"),
    ("Figure 5.3: where 16 samples are taken, by nearness and adaptively", "near-in-red", "adaptive-in-red"),
];

impl Report {
    /// With empty tables.
    pub fn new(runs: u32, threads: usize) -> Report {
        let tables = TABLES.map(|(number, title, unit, digits, note)| Table {
            number,
            title,
            unit,
            digits,
            note,
            rows: Vec::new(),
        });
        Report {
            command: format!("voxdag {}", visible(&crate::report::typed())),
            machine: Machine {
                os: std::env::consts::OS,
                architecture: std::env::consts::ARCH,
                processor: processor(),
                threads,
                version: env!("CARGO_PKG_VERSION"),
            },
            runs,
            tables: tables.into(),
            agreements: Vec::new(),
            pictures: Vec::new(),
        }
    }

    /// Puts a number into a table.
    pub fn put(&mut self, number: &str, scene: &str, configuration: &'static str, cell: Cell) {
        let Some(table) = self.tables.iter_mut().find(|table| table.number == number) else { return };
        match table.rows.iter_mut().find(|row| row.scene == scene && row.configuration == configuration) {
            Some(row) => row.cells.push(cell),
            None => table.rows.push(Row { scene: scene.to_owned(), configuration, cells: vec![cell] }),
        }
    }

    /// For people.
    pub fn markdown(&self) -> String {
        let Machine { os, architecture, processor, threads, version } = &self.machine;
        let processor = processor.as_deref().map(|name| format!("{name}, ")).unwrap_or_default();
        let mut text = format!(
            "# The thesis's tables, measured again\n\nPineda (2021), *Exploring Material Representations for Sparse Voxel \
             DAGs*: tables 5.1 to 5.8 by this program's own implementations of both sides.\n\n    {}\n\nvoxdag {version} on \
             {}{threads} threads ({os}, {architecture}). Times are medians of {} runs that took turns; pictures have \
             640x480 pixels. KB are 1024 bytes, MB 1024^2.\n",
            self.command,
            visible(&processor),
            self.runs
        );
        for table in self.tables.iter().filter(|table| !table.rows.is_empty()) {
            text += "\n";
            text += &table.markdown();
        }
        text += "\n## Equal data, equal pictures\n\n";
        for Agreement { scene, resolution, combinations, equal } in &self.agreements {
            let found = if *equal { "the same bytes" } else { "**they differ: this is a defect of voxdag**" };
            text += &format!(
                "- {scene}, {resolution}^3: {combinations} combinations of layout, materials and normals: {found}\n"
            );
        }
        if !self.pictures.is_empty() {
            text += "\n## Pictures\n\nAt the largest resolution. More of them, and the visual survey, are beside this report.\n";
            for (title, left, right) in FIGURES {
                text += &format!("\n### {title}\n\n| scene | {left} | {right} |\n| --- | --- | --- |\n");
                let of = |scene: &str, configuration: &str| {
                    let picture = self.pictures.iter().find(|p| p[0] == scene && p[1] == configuration);
                    picture.map_or(String::new(), |[.., file]| format!("![{scene}, {configuration}]({file})"))
                };
                let mut last = "";
                for [scene, ..] in &self.pictures {
                    if scene != last {
                        let name = escaped(scene);
                        text += &format!("| {name} | {} | {} |\n", of(scene, left), of(scene, right));
                        last = scene;
                    }
                }
            }
        }
        text
    }

    /// For programs: a line per number.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let failed = |error: csv::Error| Error::new(Kind::Failure, error);
        let mut out = csv::Writer::from_writer(Vec::new());
        let head = ["table", "scene", "configuration", "resolution", "unit", "value", "min", "max", "published"];
        out.write_record(head).map_err(failed)?;
        self.tables.iter().try_for_each(|table| table.csv(&mut out)).map_err(failed)?;
        out.into_inner().map_err(|error| Error::new(Kind::Failure, error))
    }

    /// For programs: everything.
    pub fn json(&self) -> Result<Vec<u8>> {
        let mut json = serde_json::to_vec_pretty(self).map_err(|error| Error::new(Kind::Failure, error))?;
        json.push(b'\n');
        Ok(json)
    }

    /// What the terminal says of the agreements.
    pub fn agreed(&self) -> String {
        let combinations: u64 = self.agreements.iter().map(|a| u64::from(a.combinations)).sum();
        match self.agreements.iter().find(|agreement| !agreement.equal) {
            Some(Agreement { scene, resolution, .. }) => format!("{scene} at {resolution}: pictures differ"),
            None => format!("{} combinations of layout, materials and normals: equal pictures", grouped(combinations)),
        }
    }

    /// Whether equal data gave equal pictures everywhere.
    pub fn all_equal(&self) -> bool {
        self.agreements.iter().all(|agreement| agreement.equal)
    }
}

/// The processor's name, where the system has `/proc/cpuinfo`.
fn processor() -> Option<String> {
    let info = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = info.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
