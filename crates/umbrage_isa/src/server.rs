//! The process that compiles.

use std::{io, os::fd::AsFd, os::unix::net::UnixStream};

use crate::{
    vulkan::Gpu,
    wire::{Device, Job, MAGIC, receive, send},
};

/// Serves the process at the other end of standard input until it is gone. `before` is called before each
/// pipeline.
pub(crate) fn serve(before: &dyn Fn(&Job)) -> io::Result<()> {
    // Standard input is one end of a pair of sockets. Standard output is left to drivers that print.
    let mut socket = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    io::Write::write_all(&mut socket, MAGIC)?;
    let gpu = Gpu::open();
    let device = gpu.as_ref().map(|gpu| Device {
        name: gpu.name().to_owned(),
    });
    send(&mut socket, &device)?;
    let Ok(gpu) = gpu else {
        return Ok(());
    };
    loop {
        let job: Job = match receive(&mut socket) {
            Ok(job) => job,
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
            Err(error) => return Err(error),
        };
        before(&job);
        send(&mut socket, &gpu.compile(&job))?;
    }
}
