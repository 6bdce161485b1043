//! Messages between the two processes: frames of postcard, each after its length.

use std::io::{self, Read, Write};

use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// Begins every conversation, so that a program that is no server is known at once.
pub(crate) const MAGIC: &[u8] = b"umbrage isa 1\n";

/// No message is longer: 64 MiB.
const LONGEST: u32 = 64 << 20;

/// The first that the server says: the device, or why there is none.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Device {
    pub(crate) name: String,
}

/// A pipeline to make. Formats, stages and the like are Vulkan's own numbers.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Job {
    /// Bindings by descriptor set.
    pub(crate) sets: Vec<Vec<Slot>>,
    pub(crate) work: Work,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Work {
    Draw(Draw),
    Compute(Shader),
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Shader {
    pub(crate) entry_point: String,
    /// SPIR-V.
    pub(crate) code: Vec<u32>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Slot {
    pub(crate) binding: u32,
    pub(crate) descriptor: i32,
    pub(crate) stages: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Draw {
    pub(crate) vertex: Shader,
    pub(crate) fragment: Option<Shader>,
    /// Each in a buffer of its own.
    pub(crate) attributes: Vec<Attribute>,
    pub(crate) topology: i32,
    pub(crate) cull: u32,
    pub(crate) front: i32,
    pub(crate) colors: Vec<Color>,
    pub(crate) depth: Option<Depth>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Attribute {
    pub(crate) location: u32,
    pub(crate) format: i32,
    /// Bytes.
    pub(crate) size: u32,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Color {
    /// `UNDEFINED` where nothing is attached.
    pub(crate) format: i32,
    pub(crate) write_mask: u32,
    /// Of colour and alpha: the source's factor, the destination's, the operation.
    pub(crate) blend: Option<[[i32; 3]; 2]>,
}

#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Depth {
    pub(crate) format: i32,
    pub(crate) compare: i32,
    pub(crate) write: bool,
}

/// Outcome of a stage.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Executable {
    pub(crate) stages: u32,
    pub(crate) statistics: Vec<(String, u64)>,
}

/// Sends a message.
pub(crate) fn send(to: &mut impl Write, message: &impl Serialize) -> io::Result<()> {
    let bytes = postcard::to_stdvec(message).map_err(io::Error::other)?;
    let length = u32::try_from(bytes.len())
        .ok()
        .filter(|length| *length <= LONGEST)
        .ok_or_else(|| io::Error::other("the message is too long"))?;
    to.write_all(&length.to_le_bytes())?;
    to.write_all(&bytes)?;
    to.flush()
}

/// Receives a message. The end of the stream is an error of the kind `UnexpectedEof`.
pub(crate) fn receive<T: DeserializeOwned>(from: &mut impl Read) -> io::Result<T> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length);
    if length > LONGEST {
        return Err(io::Error::other("the message is too long"));
    }
    let mut bytes = vec![0; length as usize];
    from.read_exact(&mut bytes)?;
    postcard::from_bytes(&bytes).map_err(io::Error::other)
}

impl Job {
    /// The names of the entry points.
    pub(crate) fn entry_points(&self) -> Vec<&str> {
        match &self.work {
            Work::Draw(draw) => [Some(&draw.vertex), draw.fragment.as_ref()]
                .into_iter()
                .flatten()
                .map(|shader| shader.entry_point.as_str())
                .collect(),
            Work::Compute(shader) => vec![&shader.entry_point],
        }
    }
}
