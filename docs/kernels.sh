#!/bin/sh
# Code of a program that draws by one kernel, which it names, by what the kernel is for (docs/effects.md): bytes of .text on
# x86-64 and of the whole file on wasm32. The first line is of one that traces and fits normals, without a renderer.
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
[dependencies]
voxdag = { path = "$core", default-features = false }
[profile.release]
lto = "fat"
codegen-units = 1
panic = "abort"
[workspace]
EOF
program() {
    cat >"$work/src/lib.rs" <<EOF
#![no_std]
#![allow(unused_imports)]
use voxdag::effects::Effects;
use voxdag::normal::{Normal, NormalKind, normals};
use voxdag::render::{Kernel, Settings, View, render_rows, render_rows_by};
use voxdag::simd::Level;
use voxdag::trace::{Arithmetic, Hit, Query, Tile};
use voxdag::{Dag, Tree, colors::Painted};

pub struct Named;
impl Kernel for Named {
    const EFFECTS: Effects = Effects::NONE$1;
}

/// What tracing and normals take without a renderer.
#[unsafe(no_mangle)]
pub fn traced(view: &View<'_, Tree<'_>, Dag<'_>>, rays: &[Query], hits: &mut [Option<Hit>], blocked: &mut [bool]) {
    view.tracer.trace_many(Arithmetic::Exact, rays, hits);
    view.tracer.occluded_many(Arithmetic::Exact, rays, blocked);
}
#[unsafe(no_mangle)]
pub fn tile(view: &View<'_, Tree<'_>, Dag<'_>>, rays: &Tile<'_>, hits: &mut [Option<Hit>]) {
    view.tracer.trace_tile(Arithmetic::Exact, rays, hits);
}
#[unsafe(no_mangle)]
pub fn fitted(level: Option<Level>, view: &View<'_, Tree<'_>, Dag<'_>>, hits: &[Hit], dirs: &[[f64; 3]], kind: NormalKind, out: &mut [Normal]) {
    normals(level, &view.tracer, view.materials, hits, dirs, kind, out);
}
$2
pub fn draw(view: &View<'_, ${4:-Tree<'_>}, Dag<'_>>, settings: &Settings, out: &mut [u32]) -> u64 {
    $3(view, settings, 0..settings.height, out).map_or(0, |counters| counters.primary)
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
            cargo build -q --release --target $target --manifest-path "$work/Cargo.toml" --target-dir "$work/target"
    done
    text=$(size -A "$work/target/x86_64-unknown-linux-gnu/release/liblinked.so" | awk '$1 == ".text" { print $2 }')
    wasm=$(stat -c %s "$work/target/wasm32-unknown-unknown/release/linked.wasm")
}
program "" "" "render_rows_by::<Named, _, _>"
measure
echo "no renderer: $text, wasm $wasm"
for set in "" "SPECULAR" "SPECULAR EMISSION" "SPECULAR SHADOWS" "SPECULAR EMISSION SHADOWS" "SPECULAR MIRROR" \
    "SPECULAR EMISSION SHADOWS MIRROR" "SPECULAR EMISSION SHADOWS TRANSPARENCY" \
    "SPECULAR EMISSION SHADOWS MIRROR TRANSPARENCY" "SPECULAR EMISSION SHADOWS MIRROR TRANSPARENCY REFRACTION"; do
    union=
    for effect in $set; do union="$union.union(Effects::$effect)"; done
    program "$union" "#[unsafe(no_mangle)]" "render_rows_by::<Named, _, _>"
    measure
    echo "${set:-none}: $text, wasm $wasm"
done
# The last set again, with textures and the colours that they need.
program "$union.union(Effects::TEXTURES)" "#[unsafe(no_mangle)]" "render_rows_by::<Named, _, _>" "Painted<'_, Tree<'_>>"
measure
echo "$set TEXTURES: $text, wasm $wasm"
program "" "#[unsafe(no_mangle)]" render_rows
measure
echo "render_rows, which chooses: $text, wasm $wasm"
