//! Outputs that are whole or not there: they grow under a temporary name beside their place and are renamed at the end.
//!
//! An output never replaces a file that the run reads, under whatever name, and never anything but a regular file.
//! Ctrl-C (and SIGTERM) removes what is half written, and folders made for nothing, and exits with 130.

use std::fs::File;
use std::io::{BufWriter, ErrorKind, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard};

use tempfile::{NamedTempFile, TempDir};

use crate::error::{Error, INTERRUPTED, Kind, Result};

type Remove = fn(&Path) -> std::io::Result<()>;

/// Whether a file was put into its place.
static WHOLE: AtomicBool = AtomicBool::new(false);

/// What to remove when the run is interrupted, the last first, and how.
static HALF_WRITTEN: Mutex<Vec<(PathBuf, Remove)>> = Mutex::new(Vec::new());

fn half_written() -> MutexGuard<'static, Vec<(PathBuf, Remove)>> {
    HALF_WRITTEN.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// From here on Ctrl-C cleans up and exits with 130.
pub fn clean_up_when_interrupted() {
    let handler = || {
        // The lock is kept, so that no file appears between here and the exit.
        let files = half_written();
        for (path, remove) in files.iter().rev() {
            let _ = remove(path);
        }
        // A progress line may stand there.
        let clear = if std::io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
        let what = match (files.is_empty(), WHOLE.load(Ordering::Relaxed)) {
            (true, _) => "",
            (false, false) => ": nothing was written",
            (false, true) => ": the files written so far are whole",
        };
        eprintln!("{clear}interrupted{what}");
        std::process::exit(INTERRUPTED);
    };
    // Without a handler an interrupt still ends the program; only a temporary file may stay.
    if let Err(cause) = ctrlc::set_handler(handler) {
        eprintln!("warning: Ctrl-C will not clean up: {cause}");
    }
}

/// Stays here for ever if an interrupt is cleaning up: what failed may have failed by that, and its exit code is to count.
pub fn wait_if_interrupted() {
    drop(half_written());
}

/// Why an output ends before it is whole.
pub enum Stop {
    /// It cannot be written.
    Write(std::io::Error),
    /// What was to be written cannot be had.
    Refused(Error),
}

impl From<std::io::Error> for Stop {
    fn from(cause: std::io::Error) -> Stop {
        Stop::Write(cause)
    }
}

impl From<Error> for Stop {
    fn from(error: Error) -> Stop {
        Stop::Refused(error)
    }
}

/// Where a stream goes: to a file, or to whoever reads stdout.
pub enum Sink {
    /// `-o FILE`.
    File(Output),
    /// `-o -`, or no `-o`.
    Stdout,
}

impl Sink {
    /// Opens the way to `path`; `None` and `-` are stdout, which then has no place for a report in JSON.
    pub fn create(path: Option<&Path>, extension: &str, json: bool) -> Result<Sink> {
        match path {
            Some(path) if path != Path::new("-") => Output::create(path, extension).map(Sink::File),
            _ if json => Err(Error::usage("--json: stdout has the result itself").hint("name a file with -o")),
            _ => Ok(Sink::Stdout),
        }
    }

    /// Refuses to replace any of the `inputs`.
    pub fn must_not_replace(&self, inputs: &[PathBuf]) -> Result<()> {
        match self {
            Sink::File(output) => output.must_not_replace(inputs),
            Sink::Stdout => Ok(()),
        }
    }

    /// Writes the content. A reader of stdout that has seen enough (`| head`) ends it, and is no failure.
    pub fn finish(self, write: impl FnOnce(&mut dyn Write) -> Result<(), Stop>) -> Result<()> {
        let Sink::File(output) = self else {
            let mut writer = BufWriter::new(std::io::stdout().lock());
            return match write(&mut writer).and_then(|()| Ok(writer.flush()?)) {
                Err(Stop::Refused(error)) => Err(error),
                Err(Stop::Write(cause)) if cause.kind() != ErrorKind::BrokenPipe => {
                    Err(Error::new(Kind::Failure, format_args!("cannot write to stdout: {cause}")))
                }
                _ => Ok(()),
            };
        };
        output.finish(|file| write(file))
    }
}

/// A file on its way.
pub struct Output {
    file: NamedTempFile,
    /// Where the user asked for it.
    path: PathBuf,
    /// Where it goes: `path`, with a symbolic link followed.
    place: PathBuf,
    /// Of the file that is there already.
    rights: Option<std::fs::Permissions>,
}

impl Output {
    /// Opens the way to `path`, which must end in `.extension`. Fails before any work is done if it cannot be written.
    pub fn create(path: &Path, extension: &str) -> Result<Output> {
        if !path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension)) {
            return Err(Error::usage(format_args!("{}: expected a name that ends in .{extension}", path.display()))
                .hint(format_args!("try -o {}", crate::report::shell_word(&path.with_extension(extension)))));
        }
        let place = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        let found = std::fs::metadata(&place).ok();
        if found.as_ref().is_some_and(|found| !found.is_file()) {
            return Err(Error::write(path, "it is there already and is not a regular file"));
        }
        let folder = match place.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };

        let mut builder = tempfile::Builder::new();
        builder.prefix(".voxdag-").suffix(".tmp");
        // As `File::create` would have it; temporary files are private by default.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));

        // Created and noted under the lock: an interrupt sees both or neither.
        let mut files = half_written();
        let file = builder.tempfile_in(folder).map_err(|cause| {
            let error = Error::write(path, cause.kind());
            match folder.is_dir() {
                true => error.hint("choose another folder with -o"),
                false => error.hint(format_args!("create {} first", folder.display())),
            }
        })?;
        files.push((file.path().to_path_buf(), |file| std::fs::remove_file(file)));
        Ok(Output { file, path: path.to_path_buf(), place, rights: found.map(|found| found.permissions()) })
    }

    /// Refuses to replace any of the `inputs`, also through links or another spelling of the path.
    pub fn must_not_replace(&self, inputs: &[PathBuf]) -> Result<()> {
        match inputs.iter().find(|input| same_file::is_same_file(input, &self.place).unwrap_or(false)) {
            Some(input) => Err(Error::usage(format_args!(
                "{}: is the input {}, which is never overwritten",
                self.path.display(),
                input.display()
            ))
            .hint("give -o another name")),
            None => Ok(()),
        }
    }

    /// Writes the content, and puts the file into its place.
    pub fn finish<E: Into<Stop>>(self, write: impl FnOnce(&mut BufWriter<&File>) -> Result<(), E>) -> Result<()> {
        let failed = |cause: std::io::Error| {
            Error::write(&self.path, cause).hint("make room there, or choose another folder with -o")
        };
        let mut writer = BufWriter::new(self.file.as_file());
        write(&mut writer).map_err(|stop| match stop.into() {
            Stop::Write(cause) => failed(cause),
            Stop::Refused(error) => error,
        })?;
        writer.into_inner().map_err(|e| failed(e.into_error()))?;
        if let Some(rights) = self.rights {
            self.file.as_file().set_permissions(rights).map_err(failed)?;
        }
        let temporary = self.file.path().to_path_buf();
        let mut files = half_written();
        self.file.persist(&self.place).map_err(|e| Error::write(&self.path, e.error))?;
        files.retain(|f| f.0 != temporary);
        WHOLE.store(true, Ordering::Relaxed);
        Ok(())
    }

    /// Gives up the way.
    pub fn discard(self) {
        let mut files = half_written();
        files.retain(|f| f.0 != self.file.path());
        drop(self.file);
    }
}

/// A folder for outputs. If it was made for them and none came, it goes again.
pub struct Folder(Option<PathBuf>);

impl Folder {
    /// Makes `path` if it is not there.
    pub fn create(path: &Path) -> Result<Folder> {
        let mut folders = half_written();
        let made = (!path.exists()).then(|| path.to_path_buf());
        std::fs::create_dir_all(path).map_err(|cause| Error::write(path, cause))?;
        folders.extend(made.clone().map(|path| -> (PathBuf, Remove) { (path, |folder| std::fs::remove_dir(folder)) }));
        Ok(Folder(made))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // Only if it is empty.
        let _ = self.0.as_ref().map(std::fs::remove_dir);
    }
}

/// A folder for files that nobody is to see, which goes with all that is in it.
pub struct Scratch(TempDir);

impl Scratch {
    /// Makes one where the system keeps such.
    pub fn create() -> Result<Scratch> {
        let mut folders = half_written();
        let folder = tempfile::tempdir().map_err(|cause| Error::write(&std::env::temp_dir(), cause))?;
        folders.push((folder.path().to_path_buf(), |folder| std::fs::remove_dir_all(folder)));
        Ok(Scratch(folder))
    }

    /// Of a file in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }
}
