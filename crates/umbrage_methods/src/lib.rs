//! umbrage_methods
