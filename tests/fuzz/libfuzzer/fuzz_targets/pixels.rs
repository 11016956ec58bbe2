#![no_main]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fuzz::pixels::try_bytes(bytes));
