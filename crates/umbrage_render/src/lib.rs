//! umbrage_render
