//! umbrage_bench
