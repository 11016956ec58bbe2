#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| _ = fuzz::link::try_bytes(bytes));
