#![no_main]
#![doc = "libFuzzer's way into the reader of the same name."]

use std::alloc::System;

#[global_allocator]
static MEMORY: cap::Cap<System> = cap::Cap::new(System, evencut_fuzz::MOST_MEMORY);

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    evencut_fuzz::tools(bytes);
});
