//! `voxdag info`: what is in a `.vxd` file.

use std::path::PathBuf;

use serde::Serialize;

use crate::error::Result;
use crate::input;
use crate::options::ReportArgs;
use crate::report::{self, Lines, grouped, shell_word, size, triple};
use crate::scene;

/// Show what a voxel scene holds
#[derive(clap::Args)]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    #[command(flatten)]
    report: ReportArgs,
}
