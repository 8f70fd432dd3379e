//! voxdag in the browser.
