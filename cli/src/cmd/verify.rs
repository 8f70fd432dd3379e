//! `voxdag verify`: the full check of a `.vxd` file, and what it consisted of.

use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::{Error, Result};
use crate::input;
use crate::options::ReportArgs;
use crate::report::{self, Lines, grouped, shell_word, size};
use crate::scene;

/// Check every word of a voxel scene
#[derive(clap::Args)]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    #[command(flatten)]
    report: ReportArgs,
}
