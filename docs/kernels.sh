#!/bin/sh
# Code that a program links which names one kernel (docs/effects.md): bytes for x86-64 (.text) and for wasm32 (the code section's
# file, all of it), by effects. The first line has everything but a renderer.
set -eu
cd "$(dirname "$0")/.."
core=$PWD/core
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/src"
cat >"$work/Cargo.toml" <<EOF
[package]
name = "linked"
version = "0.0.0"
edition = "2024"
[lib]
crate-type = ["cdylib"]
[features]
drawing = []
[dependencies]
voxdag = { path = "$core", default-features = false }
[profile.release]
lto = "fat"
codegen-units = 1
panic = "abort"
[workspace]
EOF
source() {
    cat >"$work/src/lib.rs" <<EOF
#![no_std]
use voxdag::effects::Effects;
use voxdag::normal::{Normal, NormalKind, normals};
use voxdag::render::{Kernel, Settings, View, render_rows_by};
use voxdag::trace::{Hit, Query};
use voxdag::{Dag, Tree};

struct Named;
impl Kernel for Named {
    const EFFECTS: Effects = Effects::NONE$1;
}

/// What tracing and normals take without a renderer.
#[unsafe(no_mangle)]
pub fn traced(view: &View<'_, Tree<'_>, Dag<'_>>, rays: &[Query], hits: &mut [Option<Hit>], blocked: &mut [bool]) {
    view.tracer.trace_many(voxdag::trace::Arithmetic::Exact, rays, hits);
    view.tracer.occluded_many(voxdag::trace::Arithmetic::Exact, rays, blocked);
}
#[unsafe(no_mangle)]
pub fn fitted(view: &View<'_, Tree<'_>, Dag<'_>>, hits: &[Hit], dirs: &[[f64; 3]], kind: NormalKind, out: &mut [Normal]) {
    normals(None, &view.tracer, view.materials, hits, dirs, kind, out);
}
#[cfg(feature = "drawing")]
#[unsafe(no_mangle)]
pub fn draw(view: &View<'_, Tree<'_>, Dag<'_>>, settings: &Settings, out: &mut [u32]) -> u64 {
    render_rows_by::<Named, _, _>(view, settings, 0..settings.height, out).map_or(0, |counters| counters.primary)
}
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
EOF
}
measure() {
    for target in x86_64-unknown-linux-gnu wasm32-unknown-unknown; do
        RUSTFLAGS="-C link-arg=$([ $target = wasm32-unknown-unknown ] && echo --strip-all || echo -nostartfiles)" \
            cargo build -q --release --target $target --manifest-path "$work/Cargo.toml" --target-dir "$work/target" $1
    done
    text=$(size -A "$work/target/x86_64-unknown-linux-gnu/release/liblinked.so" | awk '$1 == ".text" { print $2 }')
    wasm=$(stat -c %s "$work/target/wasm32-unknown-unknown/release/linked.wasm")
}
source ""
measure ""
base_text=$text base_wasm=$wasm
echo "no renderer: $text bytes, wasm $wasm"
for set in "" "SPECULAR" "SPECULAR EMISSION" "SPECULAR SHADOWS" "SPECULAR EMISSION SHADOWS" "SPECULAR MIRROR" \
    "SPECULAR EMISSION SHADOWS MIRROR" "SPECULAR EMISSION SHADOWS TRANSPARENCY" \
    "SPECULAR EMISSION SHADOWS MIRROR TRANSPARENCY" "SPECULAR EMISSION SHADOWS MIRROR TRANSPARENCY REFRACTION"; do
    union=
    for effect in $set; do union="$union.union(Effects::$effect)"; done
    source "$union"
    measure "--features drawing"
    echo "${set:-none}: $((text - base_text)) bytes, wasm $((wasm - base_wasm))"
done
