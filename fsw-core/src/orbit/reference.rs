//! Independent truth for the orbit's tests.
