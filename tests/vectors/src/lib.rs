//! Worked examples live in this package's `tests` folder, a file an example.
