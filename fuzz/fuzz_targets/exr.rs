#![no_main]

// The decoder is another crate, whose panics the reader catches and tells as a broken file: they are no findings, and what the
// fuzzer does on a panic, it must not do on these. What gets out of the reader, the fuzzer still sees.
libfuzzer_sys::fuzz_target!(
    init: std::panic::set_hook(Box::new(|_| ())),
    |bytes: &[u8]| etendue::fuzzing::image(bytes)
);
