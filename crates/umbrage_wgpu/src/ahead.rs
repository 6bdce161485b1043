//! Pipelines that workers make while frames go on.

use std::{
    future::Future,
    panic::{AssertUnwindSafe, catch_unwind},
    pin::pin,
    sync::Arc,
    task::{Context, Poll, Waker},
    time::Duration,
};

use umbrage_compose::{Composer, Key};

use crate::{
    DrawState, Error, Pipeline, Vertices, check::said, kept::Kept, program::PipelineId,
    vertices_read, workers::Workers,
};

/// Most pipelines that wait for workers.
const MOST_WAITING: usize = 1_024;

/// A render pipeline that is wanted, by all that it is made from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Wanted {
    /// The permutation's keys: several for a shader of several lights.
    pub keys: Vec<Key>,
    /// How it draws, with `front` as it is where nothing is mirrored.
    pub state: DrawState,
    /// Whether fronts are wound the other way.
    pub mirrored: bool,
    /// Buffers that there are, whether the shader reads them or not.
    pub vertices: Vertices,
}

/// State of something that is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Readiness {
    /// It is made: to ask for it costs a look-up.
    Ready,
    /// Workers will make it.
    Waiting,
    /// It cannot be made; why was told, once.
    Failed,
}

/// Numbers of what workers do, and of what was let go of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Backlog {
    /// Pipelines that wait, or are being made.
    pub waiting: usize,
    /// Wishes that found no room, so far: each waits again once it is asked for again.
    pub dropped: u64,
    /// Pipelines that were let go of as there were too many, so far.
    pub let_go: u64,
}

/// A pipeline, made by a worker.
type Made = Result<(PipelineId, Arc<Pipeline>), Error>;

/// State of a wish.
enum Known {
    Waiting,
    Made(PipelineId),
    /// Not told yet.
    Faulty(Error),
    Told,
}

/// Wishes, and workers that fulfil them.
pub(crate) struct Ahead {
    workers: Workers<Arc<Wanted>, Made>,
    known: Kept<Arc<Wanted>, Known>,
    frame: u64,
    dropped: u64,
}

impl Ahead {
    /// `most` pipelines are remembered.
    pub(crate) fn new(device: &wgpu::Device, composer: &Arc<Composer>, most: usize) -> Self {
        let (device, composer) = (device.clone(), Arc::clone(composer));
        Self {
            workers: Workers::new(MOST_WAITING, move |wanted: &Arc<Wanted>| {
                let made = catch_unwind(AssertUnwindSafe(|| make(&device, &composer, wanted)));
                made.unwrap_or_else(|panic| Err(wanted.fault(said(&*panic))))
            }),
            known: Kept::new(most),
            frame: 0,
            dropped: 0,
        }
    }

    /// Whether `wanted` is made, where `is_kept` tells whether a pipeline still is; if not, workers make it.
    pub(crate) fn prepare(
        &mut self,
        wanted: &Wanted,
        seen: u32,
        is_kept: impl FnOnce(&PipelineId) -> bool,
    ) -> Result<Readiness, Error> {
        match self.known.get(wanted) {
            Some(Known::Made(id)) if is_kept(id) => return Ok(Readiness::Ready),
            Some(Known::Told) => return Ok(Readiness::Failed),
            Some(known @ Known::Faulty(_)) => {
                let Known::Faulty(error) = std::mem::replace(known, Known::Told) else {
                    return Ok(Readiness::Failed);
                };
                return Err(error);
            }
            Some(Known::Waiting | Known::Made(_)) | None => {}
        }
        let wanted = Arc::new(wanted.clone());
        self.known.insert(Arc::clone(&wanted), Known::Waiting);
        if let Some(dropped) = self.workers.ask(&wanted, (self.frame, seen)) {
            self.known.remove(&dropped);
            self.dropped += 1;
        }
        Ok(Readiness::Waiting)
    }

    /// Begins a frame: gives what was made since the last one.
    pub(crate) fn begin_frame(&mut self) -> Vec<(PipelineId, Arc<Pipeline>)> {
        self.frame += 1;
        self.known.begin_frame();
        let mut pipelines = Vec::new();
        for (wanted, made) in self.workers.collect() {
            let known = match made {
                Ok((id, pipeline)) => {
                    pipelines.push((id.clone(), pipeline));
                    Known::Made(id)
                }
                Err(error) => Known::Faulty(error),
            };
            self.known.insert(wanted, known);
        }
        pipelines
    }

    /// Waits until all is made that was asked for.
    pub(crate) fn settle(&mut self) -> Vec<(PipelineId, Arc<Pipeline>)> {
        let mut pipelines = Vec::new();
        while self.workers.waiting() > 0 {
            pipelines.extend(self.begin_frame());
            std::thread::sleep(Duration::from_millis(1));
        }
        pipelines.extend(self.begin_frame());
        pipelines
    }

    pub(crate) fn backlog(&self) -> Backlog {
        Backlog {
            waiting: self.workers.waiting(),
            dropped: self.dropped,
            let_go: 0,
        }
    }

    pub(crate) fn clear(&mut self) {
        self.workers.forget();
        self.known.clear();
    }
}

impl Wanted {
    fn fault(&self, said: impl ToString) -> Error {
        let keys: Vec<_> = self.keys.iter().map(ToString::to_string).collect();
        Error::Ahead {
            keys: keys.join(" and "),
            said: said.to_string(),
        }
    }
}

/// Makes a pipeline, on whichever thread this is.
fn make(device: &wgpu::Device, composer: &Composer, wanted: &Wanted) -> Made {
    use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
    let permutation = composer.compose_all(&wanted.keys)?.permutation;
    let state = wanted.state.clone().facing(wanted.mirrored, &permutation);
    let (_, layouts) = vertices_read(&permutation, &wanted.vertices.layouts());
    let id = PipelineId::new(&permutation, state, &layouts);
    // Scopes are a thread's own: without them, the engine's handler would be told of what it has not done.
    let scopes = [OutOfMemory, Internal, Validation].map(|filter| device.push_error_scope(filter));
    let made = Pipeline::new(device, permutation, &id.state, &layouts);
    let mut refused = None;
    for scope in scopes.into_iter().rev() {
        refused = at_once(scope.pop()).flatten().or(refused);
    }
    match refused {
        Some(error) => Err(wanted.fault(error)),
        None => Ok((id, Arc::new(made?))),
    }
}

/// The outcome of a future that is done where there is no browser; none of one that is not.
fn at_once<T>(future: impl Future<Output = T>) -> Option<T> {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(done) => Some(done),
        Poll::Pending => None,
    }
}
