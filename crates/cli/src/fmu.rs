//! An FMU as a file: its sources are compiled where there is a C compiler, and everything is packed.

use anyhow::{Context, Result};
use phisindy_report::export::Fmu;
use std::fs;
use std::io::{Cursor, Write};
use std::process::{Command, Stdio};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// How a C compiler makes a library; what it rounds must not depend on the machine.
const FLAGS: [&str; 6] = ["-O2", "-std=c99", "-ffp-contract=off", "-shared", "-fPIC", "-fvisibility=hidden"];

/// The binary of this platform, by the program `cc`.
///
/// # Errors
/// Why there is none: no compiler, or what it says.
pub(crate) fn compiled(fmu: &Fmu) -> Result<Vec<u8>, String> {
    let folder = tempfile::tempdir().map_err(|e| format!("no temporary folder can be made ({e})"))?;
    let source = fmu.files.iter().find(|(path, _)| *path == fmu.source).map_or("", |(_, text)| text.as_str());
    let (from, to) = (folder.path().join("model.c"), folder.path().join("model.library"));
    fs::write(&from, source).map_err(|e| format!("its sources cannot be written for the compiler ({e})"))?;
    let said = Command::new("cc")
        .args(FLAGS)
        .arg(&from)
        .arg("-o")
        .arg(&to)
        .arg("-lm")
        .stdin(Stdio::null())
        .output()
        .map_err(|_| "there is no C compiler `cc`".to_owned())?;
    if !said.status.success() {
        let words = String::from_utf8_lossy(&said.stderr);
        return Err(format!(
            "the C compiler `cc` fails: {}",
            words.lines().next().unwrap_or("it says nothing")
        ));
    }
    fs::read(&to).map_err(|e| format!("what the compiler made cannot be read ({e})"))
}

/// The archive with all files and the binary of this platform.
///
/// # Errors
/// A file cannot be packed.
pub(crate) fn archive(fmu: &Fmu, binary: Option<Vec<u8>>) -> Result<Vec<u8>> {
    let mut files: Vec<(String, &[u8])> =
        fmu.files.iter().map(|(path, text)| (path.clone(), text.as_bytes())).collect();
    if let Some(binary) = &binary {
        let ending = std::env::consts::DLL_EXTENSION;
        files.push((format!("binaries/{}/{}.{ending}", platform(), fmu.identifier), binary));
    }
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (path, content) in files {
        zip.start_file(&path, SimpleFileOptions::default())
            .and_then(|()| Ok(zip.write_all(content)?))
            .with_context(|| format!("`{path}` cannot be packed"))?;
    }
    Ok(zip.finish().context("the archive cannot be closed")?.into_inner())
}

/// This platform as FMI 3.0 calls it (section 2.5.1.4.1): architecture and system.
fn platform() -> String {
    let system = match std::env::consts::OS {
        "macos" => "darwin",
        other => other,
    };
    format!("{}-{system}", std::env::consts::ARCH)
}
