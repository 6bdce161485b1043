//! Contents of this folder; the library itself is empty.
//!
//! - `scenes`: scene files with their models and textures, all of which `cargo xtask demo` renders.
//! - `pictures`: what each scene looks like, as `NAME.png` for `NAME.ron`.
//! - `tests/pictures.rs`: renders the scenes and compares. `UMBRAGE_BLESS=1 cargo test -p umbrage_examples`
//!   writes the pictures anew.
