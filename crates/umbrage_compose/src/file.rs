//! Texts, and the files that they came from.

use std::{fs, io, ops::Range, path::Path, sync::Arc};

use crate::{Cause, Error, Fault, error::Place};

/// A text and the file that it came from.
#[derive(Clone, Debug)]
pub(crate) struct SourceText {
    pub(crate) file: String,
    /// The text, as far as it could be read.
    pub(crate) text: Arc<str>,
    /// The reason why the file could not be read.
    pub(crate) fault: Option<Fault>,
}

impl SourceText {
    pub(crate) fn new(file: impl Into<String>, text: impl Into<Arc<str>>) -> Self {
        Self {
            file: file.into(),
            text: text.into(),
            fault: None,
        }
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let source = Self::load(path);
        match source.fault {
            Some(fault) => Err(fault.into()),
            None => Ok(source),
        }
    }

    /// Reads the file at `path`. Where that fails, keeps the fault for the moment when the text is needed.
    pub(crate) fn load(path: &Path) -> Self {
        let file = path.display().to_string();
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(error) => {
                return Self {
                    fault: Some(unreadable_fault(path, &error)),
                    ..Self::new(file, "")
                };
            }
        };
        match String::from_utf8(bytes) {
            // Some editors begin a file with a byte order mark, which is not part of the text.
            Ok(text) => Self::new(file, text.strip_prefix('\u{feff}').unwrap_or(&text)),
            Err(error) => {
                let at = error.utf8_error().valid_up_to();
                let lossy = Self::new(file, String::from_utf8_lossy(error.as_bytes()));
                let fault = not_utf8(error.as_bytes(), at).at(lossy.place(at..at + 1));
                Self {
                    fault: Some(fault),
                    ..lossy
                }
            }
        }
    }

    pub(crate) fn place(&self, range: Range<usize>) -> Place<'_> {
        Place {
            file: &self.file,
            text: &self.text,
            range,
            label: String::new(),
        }
    }
}

fn not_utf8(bytes: &[u8], at: usize) -> Fault {
    let byte = bytes.get(at).copied().unwrap_or(0);
    let message = format!("not UTF-8: the byte 0x{byte:02x} at offset {at} begins no character");
    let fault = Fault::new(Cause::File, message);
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => {
            fault.note("it begins like UTF-16: save it as UTF-8")
        }
        _ => fault.note("save it as UTF-8"),
    }
}

pub(crate) fn unreadable(path: &Path, error: &io::Error) -> Error {
    unreadable_fault(path, error).into()
}

fn unreadable_fault(path: &Path, error: &io::Error) -> Fault {
    let message = format!("`{}` cannot be read: {error}", path.display());
    Fault::new(Cause::File, message).note("check the path and its permissions")
}
