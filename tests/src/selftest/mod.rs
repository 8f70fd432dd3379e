//! The oracles against the core and the textbook methods, case by case: what `voxdag selftest` prints and the tests assert.
//!
//! In: nothing but how long it may take. Out: per case how much was tried and how often the textbook in f32, the f64
//! method and the core were wrong; the core's number must be 0. A case is cut into pieces, each of which draws from a seed
//! of its own: the sums do not depend on the number or the order of threads.
//!
//! What "wrong" means is the catalogue's (hard-cases, sections 2, 4.1 and 5). The exact methods must equal the oracle. The
//! rounded ones are measured by what they claim: overlap against closed voxels, tracers by the three inequalities.

mod leak;
mod normals;
mod overlap;
pub mod rays;

use core::ops::AddAssign;

/// What came of some tries.
#[derive(Clone, PartialEq, Eq, Debug, Default)]
pub struct Tally {
    /// How often the question was asked.
    pub tried: u64,
    /// Wrong answers of the textbook in f32.
    pub f32: u64,
    /// Wrong answers of the f64 method.
    pub f64: u64,
    /// Wrong answers of the core.
    pub ours: u64,
    /// The first of them, with all that is needed to ask again.
    pub first: Option<String>,
}

impl Tally {
    /// Counts one question.
    fn count(&mut self, f32: bool, f64: bool, ours: bool, what: impl FnOnce() -> String) {
        self.tried += 1;
        self.f32 += u64::from(!f32);
        self.f64 += u64::from(!f64);
        if !ours {
            self.ours += 1;
            self.first.get_or_insert_with(what);
        }
    }
}

impl AddAssign for Tally {
    fn add_assign(&mut self, more: Tally) {
        self.tried += more.tried;
        self.f32 += more.f32;
        self.f64 += more.f64;
        self.ours += more.ours;
        self.first = self.first.take().or(more.first);
    }
}

/// What is tried in a case.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Unit {
    /// A voxel beside a triangle.
    Voxels,
    /// A ray.
    Rays,
    /// A normal.
    Normals,
}

/// Answers the questions of one piece, which is also their seed.
type Ask = Box<dyn Fn(u64) -> Tally + Send + Sync>;

/// One line of the table.
pub struct Case {
    /// The chapter of the catalogue: `overlap`, `rays`, `leaks` or `normals`.
    pub group: &'static str,
    /// What is hard about it.
    pub name: String,
    /// What is tried.
    pub unit: Unit,
    /// Pieces of the short run and of the long one; the short one is the beginning of the long one.
    pieces: [u64; 2],
    ask: Ask,
}

impl Case {
    fn new(group: &'static str, name: String, unit: Unit, pieces: [u64; 2], ask: Ask) -> Case {
        Case { group, name, unit, pieces, ask }
    }

    /// Number of pieces; a long run has more.
    pub fn pieces(&self, long: bool) -> u64 {
        self.pieces[usize::from(long)]
    }

    /// Asks the questions of one piece.
    pub fn piece(&self, piece: u64) -> Tally {
        (self.ask)(piece)
    }

    /// Asks the questions of all pieces.
    pub fn run(&self, long: bool) -> Tally {
        let mut sum = Tally::default();
        (0..self.pieces(long)).for_each(|piece| sum += self.piece(piece));
        sum
    }
}

/// Every case, in the order of the table. Scenes are made when a case first needs them.
pub fn cases() -> Vec<Case> {
    [overlap::cases(), rays::cases(), leak::cases(), normals::cases()].into_iter().flatten().collect()
}
