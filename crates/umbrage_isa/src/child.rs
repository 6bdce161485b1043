//! The process that compiles, seen from the one that asks.

use std::{
    ffi::OsStr,
    fs::File,
    io::{self, Read, Seek},
    os::{fd::OwnedFd, unix::net::UnixStream},
    process::{self, Command, ExitStatus, Stdio},
    thread,
    time::Duration,
};

use crate::{
    CompilerOptions, IsaError, SERVE, driver,
    wire::{Device, Executable, Job, MAGIC, receive, send},
};

/// How long a program may take to start and to open its device.
const START: Duration = Duration::from_secs(30);

/// Variables that change what RADV compiles or prints: none is to leak in from outside.
const FOREIGN: [&str; 9] = [
    "ACO_DEBUG",
    "AMD_DEBUG",
    "MESA_SPIRV_DEBUG",
    "MESA_SPIRV_READ_PATH",
    "MESA_VK_VERSION_OVERRIDE",
    "NIR_DEBUG",
    "RADV_DEBUG",
    "RADV_PERFTEST",
    "VK_INSTANCE_LAYERS",
];

/// A running server.
pub(crate) struct Child {
    process: process::Child,
    socket: UnixStream,
    words: File,
}

/// How a question was not answered.
pub(crate) enum Silence {
    /// The process is gone.
    Ended(ExitStatus, String),
    /// It took too long.
    TimedOut,
}

impl Child {
    /// Starts a server for `options.family` and sees that it has that device open.
    pub(crate) fn start(options: &CompilerOptions, manifests: &OsStr) -> Result<Self, IsaError> {
        match Self::open(options, &options.family, manifests)? {
            Ok((child, device)) if driver::is_of_family(&device, &options.family) => Ok(child),
            Ok((_, device)) => Err(IsaError::OtherDevice {
                family: options.family.clone(),
                device,
            }),
            Err(said) => Err(Self::no_family(options, manifests, said)),
        }
    }

    /// Why there is no device for `options.family`: what there is instead, or what the driver `said`.
    pub(crate) fn no_family(
        options: &CompilerOptions,
        manifests: &OsStr,
        said: String,
    ) -> IsaError {
        let opens = |family: &&str| matches!(Self::open(options, family, manifests), Ok(Ok(_)));
        // Each is tried in a process of its own, most of which is waiting.
        let known = thread::scope(|scope| {
            let part =
                |names: &'static [&str]| move || names.iter().copied().filter(opens).collect();
            let parts = driver::FAMILIES.chunks(driver::FAMILIES.len().div_ceil(8));
            let parts: Vec<_> = parts.map(|names| scope.spawn(part(names))).collect();
            let joined = parts
                .into_iter()
                .map(|part| part.join().unwrap_or_default());
            joined
                .flat_map(|names: Vec<_>| names)
                .collect::<Vec<&str>>()
        });
        let known: Vec<_> = known.into_iter().map(str::to_owned).collect();
        let family = options.family.clone();
        match known.is_empty() {
            true => IsaError::NoDevice { family, said },
            false => IsaError::Family { family, known },
        }
    }

    /// A server and its device's name, or what it said where it has no device.
    fn open(
        options: &CompilerOptions,
        family: &str,
        manifests: &OsStr,
    ) -> Result<Result<(Self, String), String>, IsaError> {
        let mut child =
            Self::spawn(options, family, manifests).map_err(|source| IsaError::Start {
                program: options.program.clone(),
                source,
            })?;
        let mut magic = [0; MAGIC.len()];
        if child.socket.read_exact(&mut magic).is_err() || magic != MAGIC {
            child.end();
            return Err(IsaError::NotServing {
                program: options.program.clone(),
                said: child.said(),
            });
        }
        let device: io::Result<Result<Device, String>> = receive(&mut child.socket);
        Ok(match device {
            Ok(Ok(device)) => Ok((child, device.name)),
            Ok(Err(reason)) => Err(reason),
            // RADV ends its process where it does not know the family.
            Err(_) => {
                child.end();
                Err(child.said())
            }
        })
    }

    fn spawn(options: &CompilerOptions, family: &str, manifests: &OsStr) -> io::Result<Self> {
        let (socket, theirs) = UnixStream::pair()?;
        let words = tempfile::tempfile()?;
        let mut command = Command::new(&options.program);
        for name in FOREIGN {
            command.env_remove(name);
        }
        let process = command
            .args(&options.args)
            .env(SERVE, "1")
            // The second is the newer name, of the same meaning.
            .env("RADV_FORCE_FAMILY", family)
            .env("AMD_FORCE_FAMILY", family)
            // The second is the older name, of the same meaning.
            .env("VK_DRIVER_FILES", manifests)
            .env("VK_ICD_FILENAMES", manifests)
            // Layers that watch or draw over programs; no shader is the better for them.
            .env("VK_LOADER_LAYERS_DISABLE", "~all~")
            // Earlier results are not to be found, and nothing is written to the user's folders.
            .env("MESA_SHADER_CACHE_DISABLE", "true")
            .stdin(Stdio::from(OwnedFd::from(theirs)))
            .stdout(Stdio::null())
            .stderr(Stdio::from(words.try_clone()?))
            .spawn()?;
        socket.set_read_timeout(Some(START))?;
        Ok(Self {
            process,
            socket,
            words,
        })
    }

    /// Has a pipeline compiled. After a silence the process is gone.
    pub(crate) fn compile(
        &mut self,
        job: &Job,
        limit: Duration,
    ) -> Result<Result<Vec<Executable>, String>, Silence> {
        let limited = self.socket.set_read_timeout(Some(limit));
        let sent = limited.and_then(|()| send(&mut self.socket, job));
        sent.and_then(|()| receive(&mut self.socket))
            .map_err(|error| {
                let status = self.end();
                match error.kind() {
                    io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut => Silence::TimedOut,
                    _ => Silence::Ended(status, self.said()),
                }
            })
    }

    /// Ends the process, and says how it ended.
    fn end(&mut self) -> ExitStatus {
        // One that crashes has closed its socket and ends by itself: its status says what it died of.
        let quiet = self.socket.set_nonblocking(true);
        if quiet.is_ok() && matches!(self.socket.read(&mut [0]), Ok(0)) {
            for _ in 0..100 {
                if let Ok(Some(status)) = self.process.try_wait() {
                    return status;
                }
                thread::sleep(Duration::from_millis(10));
            }
        }
        // It fails where the process is gone already.
        drop(self.process.kill());
        self.process.wait().unwrap_or_default()
    }

    /// The end of what it wrote to standard error.
    fn said(&mut self) -> String {
        let mut bytes = Vec::new();
        let read = self.words.rewind();
        if read
            .and_then(|()| self.words.read_to_end(&mut bytes))
            .is_err()
            || bytes.is_empty()
        {
            return "nothing".to_owned();
        }
        let text = String::from_utf8_lossy(&bytes[bytes.len().saturating_sub(MOST_WORDS)..]);
        text.trim().to_owned()
    }
}

/// Bytes of a driver's words that are told.
const MOST_WORDS: usize = 2000;

impl Drop for Child {
    fn drop(&mut self) {
        drop(self.process.kill());
        drop(self.process.wait());
    }
}
