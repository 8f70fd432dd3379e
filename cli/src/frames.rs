//! The pictures of one run: a single one, or the frames of a camera path.
//!
//! In: flags and a view. Out: from where each picture is seen and the files that it becomes: of `hall.png` frames make
//! `hall_0001.png`, `hall_0002.png` and so on. All files are tried before any work is done.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::options::CameraArgs;
use crate::output::Output;
use crate::picture::{self, Shown};
use crate::view::View;

/// A picture to draw.
pub struct Shot {
    /// Its number, if it is one of a path.
    pub frame: Option<u32>,
    pub camera: CameraArgs,
    pub picture: PathBuf,
    /// Where its depths go.
    pub depths: Option<PathBuf>,
}

/// The picture that the flags ask for, or those of `frames`.
pub fn shots(
    view: &View,
    frames: Option<&RangeInclusive<u32>>,
    camera: &CameraArgs,
    picture: &Path,
    depths: Option<&Path>,
) -> Result<Vec<Shot>> {
    let Some(frames) = frames else {
        let (picture, depths) = (picture.to_path_buf(), depths.map(Path::to_path_buf));
        return Ok(vec![Shot { frame: None, camera: view.camera(camera), picture, depths }]);
    };
    let (first, last) = (frames.start(), frames.end());
    let refused = |why| Error::usage(format_args!("--frames {first}-{last}: {why}"));
    let Some(path) = view.frames() else {
        return Err(refused("there is no camera path".to_owned()).hint("give one by --view, see docs/view.md"));
    };
    if !path.contains(first) || !path.contains(last) {
        let (first, last) = (path.start(), path.end());
        return Err(refused(format!("the camera path has frames {first} to {last}"))
            .hint(format_args!("try --frames {first}-{last}")));
    }
    let shot = |frame| Shot {
        frame: Some(frame),
        camera: view.camera_at(frame, camera),
        picture: numbered(picture, frame),
        depths: depths.map(|path| numbered(path, frame)),
    };
    Ok(frames.clone().map(shot).collect())
}

/// The file of a frame: `hall.png` becomes `hall_0001.png`.
fn numbered(path: &Path, frame: u32) -> PathBuf {
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!("_{frame:04}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// The files of a picture, on their way.
pub struct Outputs {
    pub picture: Output,
    pub depths: Option<Output>,
}

impl Shot {
    /// Opens the way to its files.
    pub fn create(&self) -> Result<Outputs> {
        let depths = self.depths.as_deref().map(|path| Output::create(path, "pfm")).transpose()?;
        Ok(Outputs { picture: Output::create(&self.picture, "png")?, depths })
    }
}

/// Refuses files that cannot be written, or that are among the `inputs`. No more than one picture's are open at a time:
/// systems allow few.
pub fn check_outputs(shots: &[Shot], inputs: &[PathBuf]) -> Result<()> {
    shots.iter().try_for_each(|shot| {
        let Outputs { picture, depths } = shot.create()?;
        let checked = std::iter::once(&picture).chain(&depths).try_for_each(|output| output.must_not_replace(inputs));
        std::iter::once(picture).chain(depths).for_each(Output::discard);
        checked
    })
}

/// Refuses frames that see nothing, before any is drawn.
pub fn check_cameras(shots: &[Shot], scene: &Shown<'_>, view: &View) -> Result<()> {
    shots.iter().try_for_each(|shot| match (picture::camera(scene, &shot.camera), shot.frame, &view.file) {
        (Err(error), Some(frame), Some(file)) => {
            let message = format_args!("frame {frame}: {}", error.message());
            Err(Error::input(file, message).hint("add a key near this frame, or move those around it"))
        }
        (camera, ..) => camera.map(|_| ()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_before_the_extension() {
        assert_eq!(numbered(Path::new("a/b.c.png"), 7), Path::new("a/b.c_0007.png"));
        assert_eq!(numbered(Path::new("b"), 9999), Path::new("b_9999"));
    }
}
