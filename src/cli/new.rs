//! `etendue new`: a case file to start from.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Write};

use super::commands::{fault, print};
use super::exit;
use super::options::New;
use crate::case::TEMPLATE;

pub fn new(options: &New) -> u8 {
    new_to_end(options).map_or_else(|code| code, |()| exit::PASSED)
}

fn new_to_end(options: &New) -> Result<(), u8> {
    let mut path = options.name.clone();
    // `room.v2` is a name, too.
    if path.extension().is_none_or(|extension| extension != "toml") {
        path.as_mut_os_string().push(".toml");
    }
    let failed = |error| fault(exit::OUTPUT, format!("cannot write {}: {error}", path.display()));
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(failed)?;
    }
    let file = OpenOptions::new().write(true).create_new(true).open(&path);
    let mut file = file.map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            fault(exit::OUTPUT, format!("{} is there already, and stays as it is", path.display()))
        }
        _ => failed(error),
    })?;
    file.write_all(TEMPLATE.as_bytes()).map_err(failed)?;
    let path = path.display();
    print(&format!(
        "{path}: a case to change\n\n  etendue check {path}    every mistake at once, with its place\n  etendue exact {path}    \
         what the irradiance is\n  etendue run {path}      what the estimators make of it\n"
    ))
}
