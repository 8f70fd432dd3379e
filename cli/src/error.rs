//! The one error of the command line: a kind that fixes the exit code, a message that names the place, and a hint that
//! says what to do.
//!
//! ```text
//! error: scene.obj:17: vertex index 9 does not exist
//!   hint: the file has 8 vertices up to this line; indices count from 1
//! ```

use std::fmt::Display;
use std::path::Path;

use crate::report::visible;

/// What went wrong, in the classes that the exit code tells apart.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Kind {
    /// The machine failed us: a file that cannot be written, memory that cannot be had.
    Failure = 1,
    /// The command line makes no sense; clap exits with the same code.
    Usage = 2,
    /// An input cannot be read or is malformed.
    BadInput = 3,
    /// More memory is needed than `--memory-limit` or the format allows.
    Limit = 4,
}

/// Exit code after Ctrl-C or a request to terminate.
pub const INTERRUPTED: i32 = 130;

/// A failed command.
#[derive(Debug)]
pub struct Error {
    kind: Kind,
    message: String,
    hint: Option<String>,
}

/// The result of everything in this crate.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An error of one kind.
    pub fn new(kind: Kind, message: impl Display) -> Error {
        Error { kind, message: message.to_string(), hint: None }
    }

    /// A command line that makes no sense.
    pub fn usage(message: impl Display) -> Error {
        Error::new(Kind::Usage, message)
    }

    /// A malformed or unreadable input, named by its path.
    pub fn input(path: &Path, message: impl Display) -> Error {
        Error::new(Kind::BadInput, format_args!("{}: {message}", path.display()))
    }

    /// A file that the system would not let us write.
    pub fn write(path: &Path, cause: impl Display) -> Error {
        Error::new(Kind::Failure, format_args!("{}: cannot write: {cause}", path.display()))
    }

    /// The same error with advice.
    pub fn hint(mut self, hint: impl Display) -> Error {
        self.hint = Some(hint.to_string());
        self
    }

    /// What went wrong, without the advice.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// Prints message and hint to stderr and gives the exit code.
    pub fn report(&self) -> i32 {
        eprintln!("error: {}", visible(&self.message));
        if let Some(hint) = &self.hint {
            eprintln!("  hint: {}", visible(hint));
        }
        self.kind as i32
    }
}
