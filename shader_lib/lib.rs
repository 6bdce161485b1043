//! The WESL package.
