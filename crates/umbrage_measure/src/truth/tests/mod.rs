//! The tracer against closed forms.

mod closed_forms;
mod gaps;
mod holes;
mod on_surfaces;
mod record;
mod refusals;
mod soft;
pub(crate) mod stage;
