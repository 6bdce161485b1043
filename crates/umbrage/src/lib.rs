//! umbrage
