//! A glTF file as it is stored: its JSON, each element of which is decoded only when it is read, and the data that
//! it names.

use std::{borrow::Cow, cell::OnceCell, path::Path};

use base64::{
    Engine,
    alphabet::STANDARD,
    engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig},
};
use serde::{Deserialize, Deserializer, de::Error};
use serde_json::{Number, Value};

use super::{super::error::read, SceneError, left_out};

/// A glTF file.
pub(super) struct Document<'a> {
    pub(super) path: &'a Path,
    pub(super) json: Value,
    /// A binary file's own buffer.
    chunk: Option<&'a [u8]>,
    /// Each is loaded when it is first read.
    buffers: Vec<OnceCell<Cow<'a, [u8]>>>,
}

/// A whole number from 0, which JSON may write with a point: `3` or `3.0`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Whole(pub(super) u64);

impl Whole {
    /// As a place in a list; beyond every list where memory has no such place.
    pub(super) fn place(self) -> usize {
        usize::try_from(self.0).unwrap_or(usize::MAX)
    }
}

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        /// The whole numbers that an f64 tells apart.
        const EXACT: f64 = 9_007_199_254_740_992.0;
        let number = Number::deserialize(deserializer)?;
        let with_point = || {
            let whole = |x: &f64| x.fract() == 0.0 && (0.0..=EXACT).contains(x);
            number.as_f64().filter(whole).map(|x| x as u64)
        };
        let whole = number.as_u64().or_else(with_point).map(Self);
        whole.ok_or_else(|| D::Error::custom(format!("{number} is no whole number from 0")))
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Buffer {
    uri: Option<String>,
    byte_length: Whole,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct BufferView {
    buffer: Whole,
    #[serde(default)]
    byte_offset: Whole,
    byte_length: Whole,
    byte_stride: Option<Whole>,
}

impl<'a> Document<'a> {
    /// The file at `path`, of which `bytes` are the contents: text or binary.
    pub(super) fn parse(path: &'a Path, bytes: &'a [u8]) -> Result<Self, SceneError> {
        let broken = |problem: String| {
            let remedy = "the file is damaged or no glTF 2.0; export it again";
            SceneError::invalid(path, "file", problem, remedy)
        };
        let (text, chunk) = match bytes.starts_with(b"glTF") {
            true => split(bytes).map_err(broken)?,
            false => (bytes, None),
        };
        // Some exporters write a mark before the text, or pad it with zeros.
        let text = text.strip_prefix(b"\xef\xbb\xbf").unwrap_or(text);
        let end = text.iter().rposition(|byte| *byte != 0);
        let json: Value = serde_json::from_slice(&text[..end.map_or(0, |last| last + 1)])
            .map_err(|error| broken(error.to_string()))?;
        let version = |name: &str| {
            json.get("asset")
                .and_then(|asset| asset.get(name)?.as_str())
        };
        match version("version").map(|version| (version, version.split('.').next())) {
            Some((_, Some("2"))) => {}
            Some((other, _)) => return Err(broken(format!("it is glTF {other}"))),
            None => return Err(broken("it does not say its `asset.version`".to_owned())),
        }
        if let Some(newer) = version("minVersion").filter(|version| *version != "2.0") {
            let problem = format!("it needs a reader of glTF {newer}, and this reads 2.0");
            return Err(SceneError::invalid(path, "asset", problem, REMEDY));
        }
        let count = json
            .get("buffers")
            .and_then(Value::as_array)
            .map_or(0, Vec::len);
        let document = Self {
            path,
            json,
            chunk,
            buffers: (0..count).map(|_| OnceCell::new()).collect(),
        };
        left_out::check_required(&document)?;
        Ok(document)
    }

    pub(super) fn invalid(&self, place: &str, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(self.path, place, problem, REMEDY)
    }

    /// The elements of a list at the root, or of one within objects there, as `a.b`; none where there is no list.
    pub(super) fn list(&self, name: &str) -> &[Value] {
        let mut names = name.split('.');
        let found = names.try_fold(&self.json, |value, name| value.get(name));
        found.and_then(Value::as_array).map_or(&[], Vec::as_slice)
    }

    /// An element of a [list](Self::list), which `by` names.
    pub(super) fn element<'s, T: Deserialize<'s>>(
        &'s self,
        list: &str,
        index: Whole,
        by: &str,
    ) -> Result<T, SceneError> {
        let elements = self.list(list);
        let Some(value) = elements.get(index.place()) else {
            let problem = format!(
                "it names {list}[{}], but there are {}",
                index.0,
                elements.len()
            );
            return Err(self.invalid(by, problem));
        };
        let place = format!("{list}[{}]", index.0);
        T::deserialize(value).map_err(|error| self.invalid(&place, error.to_string()))
    }

    /// The bytes of a buffer view, which `by` names, and its stride where it has one.
    pub(super) fn view(
        &self,
        index: Whole,
        by: &str,
    ) -> Result<(&[u8], Option<usize>), SceneError> {
        let place = format!("bufferViews[{}]", index.0);
        let view: BufferView = self.element("bufferViews", index, by)?;
        let data = self.buffer(view.buffer, &place)?;
        let range = || {
            let start = view.byte_offset.0;
            let end = start.checked_add(view.byte_length.0)?;
            data.get(usize::try_from(start).ok()?..usize::try_from(end).ok()?)
        };
        let bytes = range().ok_or_else(|| {
            let problem = format!(
                "{} bytes from byte {} reach beyond buffers[{}], which has {}",
                view.byte_length.0,
                view.byte_offset.0,
                view.buffer.0,
                data.len()
            );
            self.invalid(&place, problem)
        })?;
        // Nothing stands at a distance of 0 from the next: older exporters mean none by it.
        let stride = view.byte_stride.filter(|stride| stride.0 > 0);
        Ok((bytes, stride.map(Whole::place)))
    }

    fn buffer(&self, index: Whole, by: &str) -> Result<&[u8], SceneError> {
        let buffer: Buffer = self.element("buffers", index, by)?;
        let place = format!("buffers[{}]", index.0);
        let Some(cell) = self.buffers.get(index.place()) else {
            return Err(self.invalid(&place, "there is none"));
        };
        if let Some(data) = cell.get() {
            return Ok(data);
        }
        let remedy = "the file is cut short or a part of it is missing; export the model again";
        let wrong = |problem: String| SceneError::invalid(self.path, &place, problem, remedy);
        let data = match (&buffer.uri, self.chunk) {
            (Some(uri), _) => Cow::Owned(self.load(&place, uri)?),
            (None, Some(chunk)) if index.0 == 0 => Cow::Borrowed(chunk),
            (None, _) => return Err(wrong("it has no data".to_owned())),
        };
        if (data.len() as u64) < buffer.byte_length.0 {
            return Err(wrong(format!(
                "it has {} of {} bytes",
                data.len(),
                buffer.byte_length.0
            )));
        }
        Ok(cell.get_or_init(|| data))
    }

    /// The data behind a URI: its own, or a file's beside the model.
    pub(super) fn load(&self, place: &str, uri: &str) -> Result<Vec<u8>, SceneError> {
        let invalid = |problem: String| {
            SceneError::invalid(self.path, place, problem, "name a file beside the model")
        };
        if uri
            .get(..5)
            .is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
        {
            return own_data(&uri[5..])
                .map_err(|problem| invalid(format!("bad data URI: {problem}")));
        }
        if uri.contains("://") {
            return Err(invalid(format!("`{uri}` is not a relative path")));
        }
        let folder = self.path.parent().unwrap_or(Path::new(""));
        // Exporters that encode nothing may write a `%` that is part of the name.
        let decoded =
            percent_decoded(uri.as_bytes()).and_then(|bytes| String::from_utf8(bytes).ok());
        let named = [decoded.as_deref(), Some(uri)];
        let mut files = named.into_iter().flatten().map(|name| folder.join(name));
        match (files.find(|file| file.is_file()), decoded.as_deref()) {
            (Some(file), _) => read(&file),
            (None, Some(name)) => {
                let path = folder.join(name);
                // Folders and devices are refused: reading some of them never ends.
                if path.exists() {
                    let source = std::io::Error::other("it is no file");
                    return Err(SceneError::Unreadable { path, source });
                }
                read(&path)
            }
            (None, None) => Err(invalid(format!("`{uri}` is no percent-encoded UTF-8"))),
        }
    }
}

const REMEDY: &str = "mend the model and export it again";

/// The JSON and the first binary chunk of a binary file; any other chunks belong to extensions.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |bytes: &[u8], place: usize| {
        let word = bytes.get(place..place + 4)?;
        word.try_into().ok().map(u32::from_le_bytes)
    };
    let version = word(bytes, 4).ok_or("its header is cut short")?;
    if version != 2 {
        return Err(format!("its header says that it is glTF {version}"));
    }
    let length = word(bytes, 8).ok_or("its header is cut short")?;
    if length < 12 {
        return Err(format!("its header says that it is {length} bytes long"));
    }
    let cut = || format!("it has {} of {length} bytes", bytes.len());
    let mut rest = bytes.get(12..length as usize).ok_or_else(cut)?;
    let (mut json, mut binary) = (None, None);
    // Less than a chunk's header at the end is padding.
    while let (Some(size), Some(kind)) = (word(rest, 0), rest.get(4..8)) {
        let size = size as usize;
        let chunk = rest
            .get(8..)
            .and_then(|tail| tail.get(..size))
            .ok_or_else(|| format!("a chunk of {size} bytes reaches beyond the file's {length}"))?;
        match (kind, json) {
            (b"JSON", None) => json = Some(chunk),
            (_, None) => return Err("its first chunk is not its JSON".to_owned()),
            (b"BIN\0", Some(_)) => binary = binary.or(Some(chunk)),
            _ => {}
        }
        rest = &rest[8 + size..];
    }
    let json = json.ok_or("it has no JSON")?;
    Ok((json, binary))
}

/// Bytes that a data URI holds; `rest` is the URI after its scheme.
fn own_data(rest: &str) -> Result<Vec<u8>, String> {
    let forgiving = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    let (kind, data) = rest
        .split_once(',')
        .ok_or("it has no comma before its data")?;
    let mut bytes = percent_decoded(data.as_bytes()).ok_or("a `%` is followed by no two digits")?;
    let base64 = kind.rsplit(';').next();
    if !base64.is_some_and(|word| word.trim().eq_ignore_ascii_case("base64")) {
        return Ok(bytes);
    }
    bytes.retain(|byte| !byte.is_ascii_whitespace());
    GeneralPurpose::new(&STANDARD, forgiving)
        .decode(bytes)
        .map_err(|error| error.to_string().to_lowercase())
}

fn percent_decoded(mut text: &[u8]) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    while let Some((&first, tail)) = text.split_first() {
        text = tail;
        bytes.push(match (first, tail) {
            (b'%', [high, low, tail @ ..]) => {
                text = tail;
                let digit = |d: &u8| char::from(*d).to_digit(16);
                u8::try_from(16 * digit(high)? + digit(low)?).ok()?
            }
            (b'%', _) => return None,
            _ => first,
        });
    }
    Some(bytes)
}
