//! Results: a place is tried before the work, nothing is written over unasked, and a file is written whole or not at all.

use super::ArgumentError;
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

/// Checks that a file can be written here, before the work whose result it will hold. What is there stays as it is; a device or
/// a pipe is not touched.
pub fn check_output(option: &str, path: &Path) -> Result<(), ArgumentError> {
    let refuse = |why: &dyn std::fmt::Display| {
        let found = format!("{} ({why})", path.display());
        Err(ArgumentError::new(option, found, "a file that can be written, in an existing folder"))
    };
    if path.is_dir() {
        return refuse(&"a folder");
    }
    if path.file_name().is_none() {
        return refuse(&"no name of a file");
    }
    let tried = match path.metadata() {
        Ok(found) if found.is_file() => OpenOptions::new().write(true).open(path).map(drop),
        Ok(_) => Ok(()),
        Err(_) => {
            let trial = beside(path, "try");
            OpenOptions::new().write(true).create_new(true).open(&trial).and_then(|file| {
                drop(file);
                std::fs::remove_file(&trial)
            })
        }
    };
    tried.or_else(|error| refuse(&error))
}

/// Makes a folder of results where it is missing and checks that files can be written into it.
pub fn check_folder(option: &str, folder: &Path) -> Result<(), ArgumentError> {
    let refuse = |error: io::Error| {
        let found = format!("{} ({error})", folder.display());
        ArgumentError::new(option, found, "a folder that can be written")
    };
    if !folder.as_os_str().is_empty() {
        std::fs::create_dir_all(folder).map_err(refuse)?;
    }
    let trial = folder.join(".athlete.try");
    std::fs::write(&trial, b"").and_then(|()| std::fs::remove_file(&trial)).map_err(refuse)
}

/// Refuses to replace earlier results unless `force` was asked for. `instead` says what else could be done.
pub fn keep_earlier(option: &str, files: &[PathBuf], force: bool, instead: &str) -> Result<(), ArgumentError> {
    let there: Vec<String> = files.iter().filter(|f| f.exists()).map(|f| f.display().to_string()).collect();
    if force || there.is_empty() {
        return Ok(());
    }
    let found = format!("would replace {}", there.join(", "));
    Err(ArgumentError::new(option, found, format!("{instead}, or --force to replace what is there")))
}

/// Writes a file whole or not at all: an earlier one of the name stays until the new one is complete.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let part = beside(path, "part");
    std::fs::write(&part, bytes)
        .and_then(|()| std::fs::rename(&part, path))
        .map_err(|error| format!("cannot write {}: {error}", path.display()))
}

/// About how many bytes the trace of so many steps takes: a link is written with 13 numbers of 22 to 24 characters, and what
/// touches adds a few hundred to each step.
pub fn trace_bytes(links: usize, steps: f64) -> f64 {
    steps * (355.0 * links as f64 + 700.0)
}

/// `FILE.ending` beside a file.
fn beside(path: &Path, ending: &str) -> PathBuf {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".");
    name.push(ending);
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_tried_and_what_is_there_stays() {
        let folder = std::env::temp_dir().join(format!("athlete-output-{}", std::process::id()));
        let nested = folder.join("a/b");
        check_folder("--out", &nested).unwrap();
        let file = nested.join("result.ron");
        check_output("--out", &file).unwrap();
        assert_eq!(std::fs::read_dir(&nested).unwrap().count(), 0, "a trial leaves nothing behind");
        write_whole(&file, b"old").unwrap();
        check_output("--out", &file).unwrap();
        assert_eq!(std::fs::read(&file).unwrap(), b"old");

        let earlier = [file.clone(), nested.join("none")];
        let error = keep_earlier("--out", &earlier, false, "another --out").unwrap_err().to_string();
        assert!(error.contains("result.ron") && !error.contains("none") && error.contains("--force"), "{error}");
        keep_earlier("--out", &earlier, true, "another --out").unwrap();

        // A file stands where a folder is needed; a folder where a file is.
        assert!(check_folder("--out", &file).is_err());
        let error = check_output("--trace", &nested).unwrap_err().to_string();
        assert!(error.starts_with("--trace ") && error.contains("a folder"), "{error}");
        let error = check_output("--trace", &folder.join("missing/x")).unwrap_err().to_string();
        assert!(error.contains("missing"), "{error}");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
