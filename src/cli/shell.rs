//! `sesc completions` and `sesc man`: what a shell and `man` know of the command line.

use clap::{Args, Command, CommandFactory as _};
use clap_complete::Shell;

use super::{Cli, Outcome, print_as_is};
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

pub(super) fn completions(arguments: &Completions) -> Outcome {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "sesc", &mut script);
    print_as_is(&String::from_utf8_lossy(&script))?;
    Ok(true)
}

pub(super) fn manual(arguments: &Manual) -> Outcome {
    let mut command = Cli::command();
    command.build();
    if let Some(name) = &arguments.command {
        let Some(found) = command.find_subcommand(name).cloned() else {
            let names: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
            let names = names.join(", ");
            let sentence = format!("no command `{name}`; the commands are {names}");
            return Err(Error::Usage(sentence));
        };
        command = found;
    }
    let mut text = Vec::new();
    let page = clap_mangen::Man::new(command);
    page.render(&mut text).map_err(Error::Stdout)?;
    print_as_is(&String::from_utf8_lossy(&text))?;
    Ok(true)
}
