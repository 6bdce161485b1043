//! The tracer against closed forms.

mod closed_forms;
mod holes;
mod refusals;
mod soft;
mod stage;
