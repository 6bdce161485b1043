//! glTF models, made by hand and read by [`Scene::load`](umbrage_render::Scene::load).

mod features;
mod fuzz;
mod look;
mod maker;
mod pose;
mod reading;
mod view;
