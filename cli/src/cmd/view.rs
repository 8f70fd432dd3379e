//! `voxdag view`: a scene in the page that the browser shows, served from this machine to this machine.

use std::io::Write;
use std::path::{Path, PathBuf};

use voxdag_serve::Site;

use crate::error::{Error, Kind, Result};
use crate::input;
use crate::report;
use crate::scene;

/// Look at a voxel scene in the browser
#[derive(clap::Args)]
#[command(after_help = "\
The page is made by `cargo web build` in voxdag's folder; everything runs on this machine. Ctrl-C ends it.")]
pub struct Args {
    /// A scene from `voxdag build`
    #[arg(value_name = "F.vxd")]
    scene: PathBuf,

    /// Port on this machine [default: any free one]
    #[arg(long, value_name = "N")]
    port: Option<u16>,

    /// Folder of the page [default: `www` in the folder that cargo builds this program into]
    #[arg(long, value_name = "DIR")]
    page: Option<PathBuf>,

    /// Print the address and leave the browser alone
    #[arg(long)]
    no_open: bool,
}

/// The name that the page asks for.
const NAME: &str = "scene.vxd";

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    // What is wrong with the scene is said here, not in the page.
    scene::open(&args.scene, &input::read_scene(&args.scene)?)?;
    let page = args.page.clone().or_else(built_page).unwrap_or_default();
    if !page.join("index.html").is_file() {
        return Err(Error::new(Kind::Failure, format_args!("{}: there is no page", page.display()))
            .hint("make it with `cargo web build` in voxdag's folder, or say where it is with --page DIR"));
    }
    let port = args.port.unwrap_or(0);
    let site = Site::new(&page, port)
        .map_err(|cause| Error::new(Kind::Failure, format_args!("port {port}: {cause}")).hint("take another --port"))?
        .with(NAME, &args.scene);
    let title = args.scene.file_name().map(Path::new).unwrap_or(&args.scene).display().to_string();
    let url = format!("{}#scene={NAME}&title={}", site.url(), escaped(&title));
    println!("{url}");
    // Before anything waits for the address on the other side of a pipe.
    std::io::stdout().flush().map_err(|cause| Error::new(Kind::Failure, cause))?;
    if !args.no_open
        && let Err(cause) = open::that_detached(&url)
    {
        report::warning(format_args!("no browser could be opened ({cause}); open the address above"));
    }
    site.run();
    Ok(())
}

/// The page beside the program, as cargo lays both out: `target/release/voxdag` and `target/www`.
fn built_page() -> Option<PathBuf> {
    let program = std::env::current_exe().ok()?;
    Some(program.ancestors().nth(2)?.join("www"))
}

/// A text within a URL.
fn escaped(text: &str) -> String {
    let keep = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.".contains(&byte);
    text.bytes().map(|byte| if keep(byte) { char::from(byte).to_string() } else { format!("%{byte:02X}") }).collect()
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_with_anything_in_them_stand_in_urls() {
        assert_eq!(super::escaped("a b&c#\u{e9}.vxd"), "a%20b%26c%23%C3%A9.vxd");
    }
}
