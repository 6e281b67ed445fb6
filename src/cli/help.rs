//! Completions for shells, manual pages, and the schema of case files for editors.

use clap::CommandFactory;

use super::commands::{fault, print};
use super::exit;
use super::options::{Completions, Man, Options};
use crate::case;

/// What the program is called on the command line.
const NAME: &str = "etendue";

pub fn completions(options: &Completions) -> u8 {
    let mut text = Vec::new();
    clap_complete::generate(options.shell, &mut Options::command(), NAME, &mut text);
    print(&String::from_utf8_lossy(&text)).map_or_else(|code| code, |()| exit::PASSED)
}

pub fn schema() -> u8 {
    print(&format!("{:#}\n", case::json_schema())).map_or_else(|code| code, |()| exit::PASSED)
}

pub fn man(options: &Man) -> u8 {
    man_to_end(options).map_or_else(|code| code, |()| exit::PASSED)
}

fn man_to_end(options: &Man) -> Result<(), u8> {
    let mut whole = Options::command();
    // So that pages of commands are called `etendue-run` and say `etendue run`.
    whole.build();
    let command = match &options.command {
        None => whole,
        Some(name) => whole.find_subcommand(name).cloned().ok_or_else(|| {
            let known: Vec<&str> = whole.get_subcommands().map(clap::Command::get_name).collect();
            fault(exit::USAGE, format!("no command is called {name}; there are {}", known.join(", ")))
        })?,
    };
    let mut page = Vec::new();
    clap_mangen::Man::new(command).render(&mut page).map_err(|error| fault(exit::BUG, error))?;
    print(&String::from_utf8_lossy(&page))
}
