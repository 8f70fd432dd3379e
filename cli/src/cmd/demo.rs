//! `voxdag demo`: the main job on the scene that comes along, on the way that a user's own mesh takes.

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use crate::error::Result;
use crate::options::{MachineArgs, ReportArgs};
use crate::output::Output;
use crate::report::{self, Lines, grouped, seconds, size};
use crate::{picture, scene, stats};

/// Build and draw the scene that comes along, into voxdag-demo.png
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    machine: MachineArgs,
    #[command(flatten)]
    report: ReportArgs,
}

const PICTURE: &str = "voxdag-demo.png";
