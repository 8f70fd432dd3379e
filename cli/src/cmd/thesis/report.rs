//! The report: the tables as Markdown, CSV and JSON, what they were measured on, and how far all representations agree.

use serde::Serialize;

use super::table::{Cell, Row, Table, escaped};
use crate::error::{Error, Kind, Result};
use crate::machine::Machine;
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
    /// Width and height of the pictures.
    size: [u32; 2],
    pub views: Vec<Seen>,
    /// Pictures by scene: name of the scene, of the configuration, and the file.
    #[serde(skip)]
    pub pictures: Vec<[String; 3]>,
}

/// From where a scene is seen.
#[derive(Serialize)]
pub struct Seen {
    pub scene: String,
    /// The thesis's scene that it is read as.
    pub read_as: Option<&'static str>,
    /// Flags of `render`.
    pub flags: String,
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

/// Tables by number, with title, unit, digits and what a reader must know. Those that the thesis does not have are A.1 and so on.
const TABLES: [(&str, &str, &str, usize, &str); 15] = [
    (
        "5.1",
        "Triangles and materials of the scenes",
        "number",
        0,
        "In brackets, here and below, are the thesis's own figures: for its five scenes at 256, 512 and 1024^3, and for times \
         only where picture and view are the usual ones.",
    ),
    (
        "5.2a",
        "Memory of the geometry, by the thesis's accounting",
        "KB",
        0,
        "The left part of table 5.2. Nodes are a mask and pointers of 8 bytes each. For the moxel DAG the thesis quotes a sum \
         that charges the nodes of each level with the empty counts of another: those near the root with the few that leaves \
         need, and the many nodes near the leaves with those of the root. Done right, each level is charged with its own.",
    ),
    (
        "5.2b",
        "Memory of the materials, by the thesis's accounting",
        "MB",
        1,
        "The right part of table 5.2: 24 bytes a voxel (key, normal, index) and 16 (normal, index), as if the hash table had no \
         empty slot. What this program holds is in table A.2.",
    ),
    (
        "5.3",
        "Build times of the hash table's side",
        "ms",
        1,
        "This program voxelises and reduces part by part: voxelization includes reducing each part to a DAG, and the row DAG is \
         joining the parts. The table keeps a normal with each voxel.",
    ),
    (
        "5.4",
        "Build times of the moxel side",
        "ms",
        1,
        "Both sides have the same voxeliser here. The moxel table is written in one pass over the filled voxels in Morton order.",
    ),
    (
        "5.5",
        "Render times with stored normals, 5 samples a pixel",
        "ms",
        1,
        "The normal is the triangle's, kept with the voxel: in the hash table beside the DAG, or in the moxel table, which is \
         found by the moxel DAG's empty counts.",
    ),
    (
        "5.6",
        "Memory of the hash table without normals, by the thesis's accounting",
        "MB",
        1,
        "12 bytes a voxel (key, index), as if there were no empty slot.",
    ),
    (
        "5.7",
        "Render times with calculated normals, 5 samples a pixel",
        "ms",
        1,
        "Over the voxels at most two away; the first two rows with the DAG and the hash table without normals. The first is the \
         thesis's method (`ernerfeldt2`), which leaves single dark pixels where its rule for the normal's side fails; the others \
         are this program's own, with the material tree instead of the hash table where they say so.",
    ),
    (
        "5.8",
        "Render times by supersampling",
        "ms",
        1,
        "With the DAG, the hash table without normals, and calculated normals as the thesis has them. Adaptive supersampling is \
         this program's own.",
    ),
    ("A.1", "Rays of supersampling, of those of 16 samples everywhere", "%", 1, "Of the pictures of table 5.8."),
    (
        "A.2",
        "What this program holds: every layout and representation",
        "KB",
        1,
        "Bytes as they are in memory, empty slots included. Ids by rank, palette blocks and moxel tables need counts to find \
         ranks by: the prefix counts, or those in the offsets or the moxel DAG. Normals take 4 bytes here.",
    ),
    ("A.3", "The same by filled voxel", "bits", 3, ""),
    (
        "A.4",
        "Build times of this program's own representations",
        "ms",
        1,
        "SSVDAG includes the totals that ranks need.",
    ),
    (
        "A.5",
        "Look-ups at the voxels of a picture",
        "ns",
        1,
        "CPU time of one thread, in the order of the pixels. Ids, palettes and moxel tables go by prefix counts here.",
    ),
    ("A.6", "Filled voxels", "number", 0, "Every voxel that a triangle touches."),
];

/// Pictures side by side, as the thesis has them: what each is called for people, and in file names.
type Column = (&'static str, &'static str);
const FIGURES: [(&str, &[Column]); 4] = [
    ("Figure 5.1: the scenes", &[("16 samples, calculated normals", "16-samples")]),
    ("Figure 5.2", &[("stored normals", "stored-normals"), ("calculated normals", "calculated-normals")]),
    ("Figure 5.3: where 16 samples are taken", &[("by nearness", "near-in-red"), ("adaptively", "adaptive-in-red")]),
    (
        "Figure 5.4: supersampling",
        &[("on the nearer half", "near"), ("adaptively", "adaptive"), ("every pixel", "16-samples")],
    ),
];

impl Report {
    /// With empty tables.
    pub fn new(runs: u32, threads: usize, size: [u32; 2]) -> Report {
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
            machine: Machine::with(threads),
            runs,
            tables: tables.into(),
            agreements: Vec::new(),
            size,
            views: Vec::new(),
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
        let [width, height] = self.size;
        let runs = match self.runs {
            1 => "single runs, which say little".to_owned(),
            runs => format!("medians of {runs} runs that took turns; their extremes are in the CSV"),
        };
        let mut text = format!(
            "# The thesis's tables, measured again\n\nPineda (2021), *Exploring Material Representations for Sparse Voxel \
             DAGs*: tables 5.1 to 5.8 by this program's own implementations of both sides. Why its numbers differ from the \
             thesis's is told in docs/thesis of the project.\n\n    {}\n\n{}. Times are wall-clock times, {runs}. Render times are those of tracing and shading \
             {width}x{height} pixels, making the top grid included, building the scene not. KB are 1024 bytes, MB 1024^2.\n",
            self.command,
            self.machine.text(),
        );
        for Seen { scene, read_as, flags } in &self.views {
            let read_as = read_as.map(|name| format!(", read as the thesis's {name}")).unwrap_or_default();
            text += &format!("\n- {}{read_as}: `render {flags}`", escaped(scene));
        }
        text += "\n";
        let mut of_thesis = true;
        for table in self.tables.iter().filter(|table| !table.rows.is_empty()) {
            if of_thesis && table.number.starts_with('A') {
                text += "\n# Not in the thesis\n";
                of_thesis = false;
            }
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
            text += "\n## Pictures\n\nAt the largest resolution. The folder `pictures` has more, and `survey.html` is the \
                     thesis's visual survey.\n";
            for (title, columns) in FIGURES {
                let labels: Vec<_> = columns.iter().map(|(label, _)| *label).collect();
                text += &format!(
                    "\n### {title}\n\n| scene | {} |\n| --- |{}\n",
                    labels.join(" | "),
                    " --- |".repeat(labels.len())
                );
                let mut last = "";
                for [scene, ..] in &self.pictures {
                    if scene != last {
                        let cells: Vec<_> = columns.iter().map(|(_, name)| self.picture(scene, name)).collect();
                        text += &format!("| {} | {} |\n", escaped(scene), cells.join(" | "));
                        last = scene;
                    }
                }
            }
        }
        text
    }

    /// A link to a picture.
    fn picture(&self, scene: &str, configuration: &str) -> String {
        let picture = self.pictures.iter().find(|p| p[0] == scene && p[1] == configuration);
        picture.map_or(String::new(), |[.., file]| format!("![{}, {configuration}]({file})", escaped(scene)))
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
