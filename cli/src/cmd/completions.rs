//! `voxdag completions SHELL`: the script that completes this program's commands and flags.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::error::Result;

/// Print the completion script for a shell to stdout
#[derive(clap::Args)]
pub struct Args {
    /// The shell to write for
    #[arg(value_enum)]
    shell: Shell,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<()> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut crate::Cli::command(), "voxdag", &mut script);
    crate::report::print(&script)?;
    eprintln!("next: {}", how_to_install(args.shell));
    Ok(())
}

/// The command that makes the shell find the script.
fn how_to_install(shell: Shell) -> &'static str {
    match shell {
        Shell::Bash => "voxdag completions bash > ~/.local/share/bash-completion/completions/voxdag",
        Shell::Zsh => "voxdag completions zsh > ~/.zfunc/_voxdag   (a folder that is in $fpath)",
        Shell::Fish => "voxdag completions fish > ~/.config/fish/completions/voxdag.fish",
        Shell::PowerShell => "voxdag completions powershell >> $PROFILE",
        _ => "voxdag completions elvish >> ~/.config/elvish/rc.elv",
    }
}
