//! Where the data files of a spec are, as seen from the folder of its result: a spec that is written there
//! finds them.

use crate::args::Options;
use phisindy::Loaded;
use phisindy::files::data_file;
use phisindy_phys::spec::DataSpec;
use phisindy_report::Folder;
use phisindy_report::spec_text::{COMPLETED, IDENTIFIED, with_data};
use std::path::{Component, Path, PathBuf};

/// Writes the folders of the data files into the heads of the specs among the files of a result.
pub(super) fn name_data(files: &mut Folder, spec: &Path, loaded: &Loaded, options: &Options, out: &Path) {
    let folders = folders(spec, loaded, options, out);
    for (name, text) in &mut files.files {
        if name == COMPLETED || name == IDENTIFIED {
            *text = with_data(text, &folders);
        }
    }
}

/// The folders that hold a measured record, in the order in which they are searched, relative to `out`.
fn folders(spec: &Path, loaded: &Loaded, options: &Options, out: &Path) -> Vec<String> {
    let request = options.request();
    let beside = spec.parent().map(Path::to_owned).unwrap_or_default();
    let all = request.data.into_iter().chain(request.further_data).chain([beside]);
    let files: Vec<&str> = loaded
        .parsed
        .data
        .iter()
        .filter_map(|data| match data {
            DataSpec::Csv(csv) => Some(csv.path.value.as_str()),
            DataSpec::Synthetic(_) => None,
        })
        .collect();
    let holds = |folder: &PathBuf| files.iter().any(|name| data_file(folder, name).is_some());
    let mut told: Vec<String> = all.filter(holds).filter_map(|folder| relative(&folder, out)).collect();
    told.dedup();
    told
}

/// A folder as seen from another one, which is not there before its result is.
fn relative(folder: &Path, from: &Path) -> Option<String> {
    let whole =
        |path: &Path| if path.as_os_str().is_empty() { Path::new(".") } else { path }.canonicalize().ok();
    let (folder, from) = (whole(folder)?, whole(from.parent()?)?.join(from.file_name()?));
    let shared = folder.components().zip(from.components()).take_while(|(a, b)| a == b).count();
    // Another disk of Windows.
    if matches!(folder.components().nth(shared), Some(Component::Prefix(_))) {
        return Some(folder.display().to_string());
    }
    let up = from.components().skip(shared).map(|_| Component::ParentDir);
    let path: PathBuf = up.chain(folder.components().skip(shared)).collect();
    Some(if path.as_os_str().is_empty() { ".".to_owned() } else { path.display().to_string() })
}

#[cfg(test)]
mod tests {
    use super::relative;

    #[test]
    fn a_folder_is_seen_from_another_one() {
        let top = tempfile::tempdir().expect("a folder");
        for name in ["a/b", "c d"] {
            std::fs::create_dir_all(top.path().join(name)).expect("a folder");
        }
        let seen = |folder: &str, from: &str| relative(&top.path().join(folder), &top.path().join(from));
        assert_eq!(seen("c d", "a/b").as_deref(), Some("../../c d"));
        assert_eq!(seen("a/b", "a").as_deref(), Some("b"));
        assert_eq!(seen("a", "a").as_deref(), Some("."));
        assert_eq!(seen("nowhere", "a"), None);
        assert_eq!(seen("c d", "a/new").as_deref(), Some("../../c d"));
    }
}
