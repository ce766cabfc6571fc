//! Completions of the command line and manual pages, from the same description as `--help`.

use crate::args::{Options, description};
use crate::outdir::OutDir;
use crate::terminal::print;
use anyhow::{Context, Result};
use clap::Command;
use clap_complete::Shell;
use clap_mangen::Man;
use std::io;

/// Prints the completion script of a shell.
pub(crate) fn completions(shell: Shell) -> Result<u8> {
    let mut text = Vec::new();
    clap_complete::generate(shell, &mut description(), "phisindy", &mut text);
    print(&String::from_utf8_lossy(&text))?;
    Ok(0)
}

/// Prints the manual of the whole program, or writes a page for it and one for each subcommand into --out.
pub(crate) fn pages(options: &Options) -> Result<u8> {
    let mut program = description();
    // Propagates the global options to the subcommands.
    program.build();
    let subcommands: Vec<Command> =
        program.get_subcommands().filter(|s| !s.is_hide_set() && s.get_name() != "help").cloned().collect();
    if let Some(out) = &options.out {
        let folder = OutDir::create(out)?;
        folder.write("phisindy.1", &page(&program)?)?;
        for subcommand in &subcommands {
            folder.write(&format!("phisindy-{}.1", subcommand.get_name()), &page(subcommand)?)?;
        }
        return Ok(0);
    }
    let mut text = page(&program)?;
    for subcommand in subcommands {
        let name = subcommand.get_bin_name().unwrap_or(subcommand.get_name()).to_uppercase();
        text += &format!(".SH \"{name}\"\n");
        // Its sections become subsections.
        text += &sections(&subcommand)?.replace("\n.SH ", "\n.SS ").replacen(".SH ", ".SS ", 1);
    }
    print(&text)?;
    Ok(0)
}

/// A page of its own.
fn page(command: &Command) -> Result<String> {
    let name = command.get_bin_name().unwrap_or(command.get_name()).replace(' ', "-");
    let man = Man::new(command.clone()).title(name);
    let title = rendered(|out| man.render_title(out))?;
    Ok(title + &sections(command)?)
}

/// The sections of a page, examples right after the synopsis.
fn sections(command: &Command) -> Result<String> {
    let man = Man::new(command.clone());
    let mut text = rendered(|out| {
        man.render_name_section(out)?;
        man.render_synopsis_section(out)
    })?;
    if let Some(examples) = command.get_before_help() {
        text += &examples_section(&examples.to_string());
    }
    text += &rendered(|out| {
        man.render_description_section(out)?;
        man.render_options_section(out)?;
        if command.get_subcommands().any(|s| !s.is_hide_set()) {
            man.render_subcommands_section(out)?;
        }
        if command.get_after_help().is_some() {
            man.render_extra_section(out)?;
        }
        Ok(())
    })?;
    Ok(text)
}

/// Examples line by line, as they are typed.
fn examples_section(examples: &str) -> String {
    let lines = examples.lines().filter(|line| line.trim() != "Examples:").map(|line| {
        let line = line.trim_end().replace('\\', "\\e").replace('-', "\\-").replace('\'', "\\(aq");
        // A dot in front would be a request of roff.
        format!("\\&{line}\n")
    });
    format!(".SH EXAMPLES\n.nf\n{}.fi\n", lines.collect::<String>())
}

fn rendered(write: impl FnOnce(&mut dyn io::Write) -> io::Result<()>) -> Result<String> {
    let mut out = Vec::new();
    write(&mut out).context("a manual page cannot be made")?;
    Ok(String::from_utf8_lossy(&out).into_owned())
}
