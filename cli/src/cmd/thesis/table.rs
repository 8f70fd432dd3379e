//! A table of the report: rows of a scene and a configuration, a cell per resolution, for Markdown, CSV and JSON.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::measure::Spread;

/// A table, numbered as in the thesis; those that it does not have are A.1 and so on.
#[derive(Serialize)]
pub struct Table {
    /// Such as `5.2`.
    pub number: &'static str,
    pub title: &'static str,
    /// Of all cells.
    pub unit: &'static str,
    /// Digits behind the point, for people.
    #[serde(skip)]
    pub digits: usize,
    /// What a reader must know to read it.
    pub note: &'static str,
    pub rows: Vec<Row>,
}

/// A configuration of a scene.
#[derive(Serialize)]
pub struct Row {
    pub scene: String,
    pub configuration: &'static str,
    pub cells: Vec<Cell>,
}

/// A number, and the thesis's where it has one.
#[derive(Serialize, Clone, Copy)]
pub struct Cell {
    /// Voxels along the longest axis; 0 where it does not matter.
    pub resolution: u32,
    /// The median where there are several runs.
    pub value: f64,
    pub min: f64,
    pub max: f64,
    pub published: Option<f64>,
}

impl Cell {
    /// Of a number that is what it is, however often it is asked for.
    pub fn exact(resolution: u32, value: f64, published: Option<u32>) -> Cell {
        Cell { resolution, value, min: value, max: value, published: published.map(f64::from) }
    }

    /// Of several runs.
    pub fn spread(resolution: u32, runs: Spread, published: Option<u32>) -> Cell {
        let Spread { median, min, max } = runs;
        Cell { resolution, value: median, min, max, published: published.map(f64::from) }
    }
}

impl Table {
    /// For people: the thesis's figures stand in brackets.
    pub fn markdown(&self) -> String {
        let mut text = format!("## Table {}: {} ({})\n\n", self.number, self.title, self.unit);
        let resolutions: BTreeSet<u32> =
            self.rows.iter().flat_map(|row| &row.cells).map(|cell| cell.resolution).collect();
        let columns: Vec<_> =
            resolutions.iter().map(|n| if *n == 0 { self.unit.to_owned() } else { format!("{n}^3") }).collect();
        text += &format!(
            "| scene | configuration | {} |\n| --- | --- |{}\n",
            columns.join(" | "),
            " ---: |".repeat(columns.len())
        );
        let mut last = "";
        for row in &self.rows {
            let cells = resolutions.iter().map(|n| match row.cells.iter().find(|cell| cell.resolution == *n) {
                Some(cell) => self.cell(cell),
                None => String::new(),
            });
            let scene = if row.scene == last { "" } else { &row.scene };
            text += &format!(
                "| {} | {} | {} |\n",
                escaped(scene),
                row.configuration,
                cells.collect::<Vec<_>>().join(" | ")
            );
            last = &row.scene;
        }
        if !self.note.is_empty() {
            text += &format!("\n{}\n", self.note);
        }
        text
    }

    fn cell(&self, cell: &Cell) -> String {
        let digits = self.digits;
        match cell.published {
            Some(published) => format!("{:.digits$} ({published})", cell.value),
            None => format!("{:.digits$}", cell.value),
        }
    }

    /// For programs: a line per cell.
    pub fn csv<W: std::io::Write>(&self, out: &mut csv::Writer<W>) -> csv::Result<()> {
        for row in &self.rows {
            for cell in &row.cells {
                let Cell { resolution, value, min, max, published } = *cell;
                let published = published.map(|x| x.to_string()).unwrap_or_default();
                let numbers = [value, min, max].map(|x| x.to_string());
                let resolution = resolution.to_string();
                out.write_record(
                    [self.number, &row.scene, row.configuration, &resolution, self.unit]
                        .into_iter()
                        .chain(numbers.iter().map(String::as_str))
                        .chain([published.as_str()]),
                )?;
            }
        }
        Ok(())
    }
}

/// Names come from files: nothing in them may end a cell.
pub fn escaped(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect::<String>().replace('|', "\\|")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cell_of_runs_is_their_median_and_spread() {
        let cell = Cell::spread(256, Spread::of([9.0, 1.0, 4.0]), None);
        assert_eq!((cell.value, cell.min, cell.max), (4.0, 1.0, 9.0));
        assert_eq!(Cell::spread(256, Spread::of([4.0, 1.0]), None).value, 2.5);
    }

    #[test]
    fn a_table_for_people_has_the_published_figures_in_brackets() {
        let row = |scene: &str, configuration, cells| Row { scene: scene.to_owned(), configuration, cells };
        let table = Table {
            number: "5.2",
            title: "Memory",
            unit: "KB",
            digits: 1,
            note: "",
            rows: vec![
                row("a|b", "DAG", vec![Cell::exact(256, 1.25, Some(2)), Cell::exact(512, 3.0, None)]),
                row("a|b", "moxel", vec![Cell::exact(512, 4.0, None)]),
            ],
        };
        assert_eq!(
            table.markdown(),
            "## Table 5.2: Memory (KB)\n\n| scene | configuration | 256^3 | 512^3 |\n| --- | --- | ---: | ---: |\n\
             | a\\|b | DAG | 1.2 (2) | 3.0 |\n|  | moxel |  | 4.0 |\n"
        );
        let mut out = csv::Writer::from_writer(Vec::new());
        table.csv(&mut out).unwrap();
        let text = String::from_utf8(out.into_inner().unwrap()).unwrap();
        assert_eq!(text.lines().next(), Some("5.2,a|b,DAG,256,KB,1.25,1.25,1.25,2"));
        assert_eq!(text.lines().count(), 3);
    }
}
