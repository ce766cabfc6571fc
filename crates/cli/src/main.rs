//! `phisindy`: see `lib.rs`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(phisindy_cli::program(std::env::args_os()))
}
