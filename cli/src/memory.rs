//! The account of `--memory-limit`: what is held now, and what more would be too much.
//!
//! Each stage asks before it takes, and notes what stays when it is over. What a stage takes on the way is estimated;
//! the program itself (a few MiB) is not counted.

use crate::error::{Error, Kind, Result};
use crate::report::size;

/// Bytes held, and the most that may be.
pub struct Memory {
    limit: Option<u64>,
    held: u64,
}

impl Memory {
    /// Nothing is held yet.
    pub fn new(limit: Option<u64>) -> Memory {
        Memory { limit, held: 0 }
    }

    /// Bytes that may still be taken; `None` if there is no limit.
    pub fn left(&self) -> Option<u64> {
        self.limit.map(|limit| limit.saturating_sub(self.held))
    }

    /// The same account with so many bytes more that are held.
    pub fn with(&self, bytes: u64) -> Memory {
        Memory { held: self.held.saturating_add(bytes), ..*self }
    }

    /// Bytes that are held.
    pub fn held(&self) -> u64 {
        self.held
    }

    /// Notes that so many bytes stay.
    pub fn hold(&mut self, bytes: u64) {
        self.held = self.held.saturating_add(bytes);
    }

    /// Notes that so many bytes are given back.
    pub fn release(&mut self, bytes: u64) {
        self.held = self.held.saturating_sub(bytes);
    }

    /// Refuses to take `more` bytes beside those held if that is over the limit; `what` names what they are for.
    pub fn afford(&self, more: u64, what: &str, hint: &str) -> Result<()> {
        let needed = self.held.saturating_add(more);
        match self.limit {
            Some(limit) if needed > limit => Err(Error::new(
                Kind::Limit,
                format_args!("{what} needs {needed} bytes ({}), the limit is {limit} ({})", size(needed), size(limit)),
            )
            .hint(hint)),
            _ => Ok(()),
        }
    }
}

/// A size as it can be typed, a quarter larger.
pub fn round_up(bytes: u64) -> String {
    let mebibytes = (bytes.saturating_add(bytes / 4)).div_ceil(1 << 20);
    if mebibytes < 4096 { format!("{mebibytes}M") } else { format!("{}G", mebibytes.div_ceil(1024)) }
}
