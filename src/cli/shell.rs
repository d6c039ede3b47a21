//! `sesc completions` and `sesc man`: what a shell and `man` know of the command line.

use clap::{Args, Command, CommandFactory as _};
use clap_complete::Shell;

use super::{Cli, Outcome, print};
use crate::Error;

/// Print the completions of a shell
#[derive(Args)]
#[command(
    after_help = "Examples:\n  sesc completions bash > ~/.local/share/bash-completion/completions/sesc\n  sesc completions fish > ~/.config/fish/completions/sesc.fish"
)]
pub(super) struct Completions {
    /// Shell
    #[arg(value_enum)]
    shell: Shell,
}

/// Print a manual page
#[derive(Args)]
#[command(after_help = "Examples:\n  sesc man | man -l -\n  sesc man fit > sesc-fit.1")]
pub(super) struct Manual {
    /// Command; the page of `sesc` itself unless given
    command: Option<String>,
}

pub(super) fn completions(arguments: &Completions) -> Result<Outcome, Error> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "sesc", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Ok)
}

pub(super) fn manual(arguments: &Manual) -> Result<Outcome, Error> {
    let mut command = Cli::command();
    command.build();
    let page = match &arguments.command {
        None => command,
        Some(name) => of(&command, name)?,
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page)
        .render(&mut text)
        .map_err(Error::Stdout)?;
    print(&String::from_utf8_lossy(&text))?;
    Ok(Outcome::Ok)
}

fn of(command: &Command, name: &str) -> Result<Command, Error> {
    let found = command.find_subcommand(name).cloned();
    found.ok_or_else(|| {
        let names: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        Error::Usage(format!(
            "no command `{name}`; the commands are {}",
            names.join(", ")
        ))
    })
}
