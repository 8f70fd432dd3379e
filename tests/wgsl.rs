//! The shader as far as it can be tested without a graphics card: it is WGSL by the reference implementation, every back
//! end writes it, and the uniform points at the sections. What it computes is tested by tests/gpu on a real adapter.

use naga::back::{glsl, hlsl, msl, spv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Module, ShaderStage};
use voxdag::wgsl;

/// The whole text with the example behind it.
fn picture() -> String {
    format!("{}\n{}", wgsl::SOURCE, wgsl::PICTURE)
}

fn checked(source: &str) -> (Module, ModuleInfo) {
    let module = naga::front::wgsl::parse_str(source).unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    // No capabilities: what every card has.
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(&module)
        .unwrap_or_else(|e| panic!("{}", e.emit_to_string(source)));
    (module, info)
}

#[test]
fn the_source_is_valid_alone_and_with_the_example() {
    checked(wgsl::SOURCE);
    checked(&picture());
}
