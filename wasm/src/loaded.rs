//! A scene with the words that it was read from: checked once, then a view that costs nothing.

use voxdag::file::{self, LoadError, Scene};

self_cell::self_cell!(
    struct Cell {
        owner: Vec<u32>,
        #[covariant]
        dependent: Scene,
    }
);

/// The words of a file, and the scene in them.
pub struct Loaded(Cell);

impl Loaded {
    /// Checks the words.
    pub fn new(words: Vec<u32>) -> Result<Loaded, LoadError> {
        Cell::try_new(words, |words| file::read(words)).map(Loaded)
    }

    /// The scene.
    pub fn scene(&self) -> &Scene<'_> {
        self.0.borrow_dependent()
    }

    /// The words of the file.
    pub fn words(&self) -> &[u32] {
        self.0.borrow_owner()
    }
}
