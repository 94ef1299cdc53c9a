//! One harness for all targets: `MIDSURF_FUZZ=TARGET midsurf-fuzz CORPUS`, as
//! `tools/fuzz/run` starts it.

#![no_main]

mod checks;
mod solids;

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;

static TARGET: LazyLock<String> =
    LazyLock::new(|| std::env::var("MIDSURF_FUZZ").expect("MIDSURF_FUZZ names a target"));

fuzz_target!(|bytes: &[u8]| match TARGET.as_str() {
    "extract" => checks::extracts(&solids::solid(bytes)),
    "roundtrip" => checks::goes_round(&solids::solid(bytes)),
    "offset" => checks::offsets(&solids::solid(bytes)),
    "thicken" => checks::thickens(&solids::sheet(bytes)),
    "repair" => checks::repairs(&solids::soup(bytes)),
    // All others are suffixes of files.
    suffix => checks::reads(bytes, format!("a.{suffix}").as_ref()),
});
