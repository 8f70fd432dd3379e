//! `cargo web build` packs the page into `target/www` and a package for npm into `target/npm`; `cargo web serve` serves the
//! page. Both need nothing but the Rust toolchain with its target wasm32-unknown-unknown.
//!
//! ```text
//! wasm/src --cargo--> target/wasm32-unknown-unknown/web/voxdag_wasm.wasm --wasm-bindgen--> voxdag.js, voxdag_bg.wasm, types
//! target/www: wasm/www and these in pkg/     target/npm: wasm/npm and these
//! ```

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::{env, fs};

use voxdag_serve::Site;
use wasm_bindgen_cli_support::Bindgen;

const USAGE: &str = "\
usage: cargo web build          pack the page into target/www, and an npm package into target/npm
       cargo web serve [PORT]   serve target/www [default: port 8080]";

fn main() -> ExitCode {
    let args: Vec<String> = env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let done = match args[..] {
        ["build"] => build(),
        ["serve"] => serve("8080"),
        ["serve", port] => serve(port),
        _ => {
            eprintln!("{USAGE}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// The workspace's folder: where `cargo web` runs this tool, even if it was compiled before the folder was moved.
fn root() -> PathBuf {
    let mut here = env::var_os("CARGO_MANIFEST_DIR").map_or(env!("CARGO_MANIFEST_DIR").into(), PathBuf::from);
    here.pop();
    here.pop();
    here
}

/// Where cargo puts what it builds.
fn target() -> PathBuf {
    let given = env::var_os("CARGO_TARGET_DIR").map(PathBuf::from);
    given.map_or(root().join("target"), |given| std::path::absolute(&given).unwrap_or(given))
}

fn build() -> Result<(), Box<dyn Error>> {
    let (root, target) = (root(), target());
    let cargo = env::var_os("CARGO").unwrap_or("cargo".into());
    let status = Command::new(cargo)
        .args(["build", "--locked", "--profile", "web", "-p", "voxdag-wasm", "--target", "wasm32-unknown-unknown"])
        .current_dir(&root)
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .env("CARGO_TARGET_DIR", &target)
        // All browsers since 2023 have vectors; docs/browser.md says what they bring.
        .env("RUSTFLAGS", "-C target-feature=+simd128")
        .status()?;
    if !status.success() {
        return Err("the wasm module could not be built (rustup target add wasm32-unknown-unknown)".into());
    }

    let glue = target.join("web-pkg");
    fresh(&glue)?;
    Bindgen::new()
        .input_path(target.join("wasm32-unknown-unknown/web/voxdag_wasm.wasm"))
        .web(true)?
        // Else `init()` without an argument does not find the module.
        .omit_default_module_path(false)
        .typescript(true)
        .remove_name_section(true)
        .remove_producers_section(true)
        .out_name("voxdag")
        .generate(&glue)
        .map_err(|error| format!("wasm-bindgen: {error:#}"))?;

    let (www, npm) = (target.join("www"), target.join("npm"));
    fresh(&www)?;
    copy(&root.join("wasm/www"), &www)?;
    copy(&glue, &www.join("pkg"))?;
    fresh(&npm)?;
    copy(&root.join("wasm/npm"), &npm)?;
    copy(&glue, &npm)?;
    for licence in ["LICENSE-APACHE", "LICENSE-MIT"] {
        fs::copy(root.join(licence), npm.join(licence))?;
    }
    let manifest = fs::read_to_string(npm.join("package.json"))?;
    fs::write(npm.join("package.json"), manifest.replace("0.0.0", env!("CARGO_PKG_VERSION")))?;

    let bytes = fs::metadata(www.join("pkg/voxdag_bg.wasm"))?.len();
    println!("page         {}", www.display());
    println!("npm package  {}", npm.display());
    println!("wasm         {bytes} bytes");
    println!("next: cargo web serve");
    Ok(())
}

fn serve(port: &str) -> Result<(), Box<dyn Error>> {
    let www = target().join("www");
    if !www.join("index.html").is_file() {
        return Err(format!("there is no page in {}: make it with `cargo web build`", www.display()).into());
    }
    let port = port.parse().map_err(|_| format!("port {port}: expected a number, 0 to 65535"))?;
    let site = Site::new(&www, port).map_err(|error| format!("port {port}: {error}"))?;
    println!("{}", site.url());
    site.run();
    Ok(())
}

/// An empty folder.
fn fresh(folder: &Path) -> std::io::Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder)?;
    }
    fs::create_dir_all(folder)
}

/// Copies a folder's files and folders into another one.
fn copy(from: &Path, to: &Path) -> std::io::Result<()> {
    fs::create_dir_all(to)?;
    for entry in fs::read_dir(from)? {
        let entry = entry?;
        let (path, to) = (entry.path(), to.join(entry.file_name()));
        if entry.file_type()?.is_dir() {
            copy(&path, &to)?;
        } else {
            fs::copy(&path, &to)?;
        }
    }
    Ok(())
}
