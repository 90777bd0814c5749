//! Bounded reads of regular files, for every loader of the crate.
//!
//! A path from outside may lead to a pipe that never speaks, to a device without an end or to a folder. What kind of file it
//! is and how long is asked before it is opened, and no more than the limit is read even where the file grows meanwhile.

use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Why a file was not read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct ReadFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: ReadFault,
}

/// What is wrong with a file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReadFault {
    /// The system refuses.
    #[error("{reason}")]
    System {
        /// The kind of refusal.
        kind: io::ErrorKind,
        /// The system's words.
        reason: String,
    },
    /// A folder, a pipe, a socket or a device.
    #[error("is {kind}; valid: a regular file")]
    NotRegular {
        /// What it is, with its article.
        kind: &'static str,
    },
    /// Longer than any sensible file of its kind.
    #[error("{bytes} bytes; valid: at most {limit} bytes")]
    TooLarge {
        /// Bytes found (one more than the limit where the file does not tell).
        bytes: u64,
        /// Most bytes.
        limit: u64,
    },
    /// Not UTF-8.
    #[error("byte {at} is not UTF-8 text")]
    NotText {
        /// Offset of the first bad byte.
        at: usize,
    },
}

impl From<ReadFileError> for io::Error {
    fn from(error: ReadFileError) -> Self {
        let kind = match &error.fault {
            ReadFault::System { kind, .. } => *kind,
            ReadFault::NotRegular { .. } => io::ErrorKind::InvalidInput,
            ReadFault::TooLarge { .. } | ReadFault::NotText { .. } => io::ErrorKind::InvalidData,
        };
        // The path is named by the errors that carry this one.
        io::Error::new(kind, error.fault.to_string())
    }
}

/// What a file that is not regular is.
fn kind(metadata: &Metadata) -> &'static str {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = metadata.file_type();
        if kind.is_fifo() {
            return "a pipe";
        }
        if kind.is_char_device() || kind.is_block_device() {
            return "a device";
        }
        if kind.is_socket() {
            return "a socket";
        }
    }
    if metadata.is_dir() { "a folder" } else { "no regular file" }
}

/// Reads a regular file of at most `limit` bytes. Links are followed; what they lead to must be a regular file.
pub fn read_bytes(path: impl AsRef<Path>, limit: u64) -> Result<Vec<u8>, ReadFileError> {
    let path = path.as_ref();
    let fail = |fault| ReadFileError { path: path.to_path_buf(), fault };
    let system = |error: io::Error| fail(ReadFault::System { kind: error.kind(), reason: error.to_string() });
    let check = |metadata: &Metadata| {
        if !metadata.is_file() {
            return Err(fail(ReadFault::NotRegular { kind: kind(metadata) }));
        }
        if metadata.len() > limit {
            return Err(fail(ReadFault::TooLarge { bytes: metadata.len(), limit }));
        }
        Ok(())
    };
    // Before it is opened, since opening a pipe waits; and again for what was opened.
    check(&std::fs::metadata(path).map_err(system)?)?;
    let file = File::open(path).map_err(system)?;
    let metadata = file.metadata().map_err(system)?;
    check(&metadata)?;
    let mut bytes = Vec::with_capacity(usize::try_from(metadata.len()).unwrap_or_default());
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(system)?;
    if bytes.len() as u64 > limit {
        return Err(fail(ReadFault::TooLarge { bytes: bytes.len() as u64, limit }));
    }
    Ok(bytes)
}

/// Reads a regular file of at most `limit` bytes of UTF-8 text. A byte-order mark at its start is skipped.
pub fn read_text(path: impl AsRef<Path>, limit: u64) -> Result<String, ReadFileError> {
    let path = path.as_ref();
    let mut text = String::from_utf8(read_bytes(path, limit)?).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        ReadFileError { path: path.to_path_buf(), fault: ReadFault::NotText { at } }
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("bevy_athlete_read_file_{name}_{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        folder
    }

    #[test]
    fn limits_folders_and_bad_text_are_named() {
        let folder = folder("limits");
        let file = folder.join("a.txt");
        std::fs::write(&file, "\u{feff}twelve bytes").unwrap();
        assert_eq!(read_text(&file, 15).unwrap(), "twelve bytes");
        assert_eq!(read_bytes(&file, 14).unwrap_err().fault, ReadFault::TooLarge { bytes: 15, limit: 14 });
        assert_eq!(read_bytes(&folder, 99).unwrap_err().fault, ReadFault::NotRegular { kind: "a folder" });
        std::fs::write(&file, [b'a', 0xff]).unwrap();
        let message = read_text(&file, 9).unwrap_err().to_string();
        assert!(message.contains("a.txt") && message.contains("byte 1"), "{message}");
        let missing = read_bytes(folder.join("none"), 9).unwrap_err();
        assert!(matches!(missing.fault, ReadFault::System { kind: io::ErrorKind::NotFound, .. }));
        std::fs::remove_dir_all(&folder).unwrap();
    }

    /// A link to a device without an end, and a pipe that nobody writes to: both would be read for ever.
    #[cfg(unix)]
    #[test]
    fn devices_and_pipes_are_refused_at_once() {
        let folder = folder("devices");
        let link = folder.join("endless.bvh");
        std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
        assert_eq!(read_bytes(&link, 1 << 20).unwrap_err().fault, ReadFault::NotRegular { kind: "a device" });
        let pipe = folder.join("pipe.bvh");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        if made.is_ok_and(|status| status.success()) {
            assert_eq!(read_bytes(&pipe, 1 << 20).unwrap_err().fault, ReadFault::NotRegular { kind: "a pipe" });
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
