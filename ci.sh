#!/usr/bin/env bash
# Every check of this project, one function each.
#
#   ./ci.sh            all of them, in this order; the rest still run when one fails
#   ./ci.sh test       one of them
#   ./ci.sh miri long  everything that Miri can do, on three machines (7 minutes instead of 2)
#   ./ci.sh gpu long   the shader on ten times as many rays (1 minute instead of 15 seconds)
#   ./ci.sh selftest long   the oracles over a hundred times as many triangles and rays (some minutes instead of seconds)
#   ./ci.sh fuzz 60    every fuzz target for 60 seconds (nightly and cargo-fuzz needed; not part of `all`)
#   ./ci.sh mutants    every rule and check taken away in turn: does a test notice? (python3 needed; not part of `all`)
set -euo pipefail
cd "$(dirname "$0")"

ALL=(lock fmt mutants_fit clippy doc no_std wasm fuzz_builds demo web selftest test targets gpu miri)

# The lock files are committed and fit their manifests.
check_lock() {
    local folder
    for folder in . fuzz tests/bare tests/gpu; do
        cargo metadata --locked --format-version 1 --manifest-path "$folder/Cargo.toml" >/dev/null
    done
}

check_fmt() {
    cargo fmt --all --check
    rustfmt --edition 2024 --check fuzz/fuzz_targets/*.rs tests/bare/build.rs tests/bare/src/*.rs tests/gpu/src/*.rs
}

check_clippy() {
    cargo clippy --locked --workspace --all-targets -- -D warnings
    # Without what needs a C++ compiler.
    cargo clippy --locked -p voxdag-cli --all-targets --no-default-features -- -D warnings
}

check_doc() {
    RUSTDOCFLAGS=-Dwarnings cargo doc --locked --no-deps --workspace
}

# The core as a library alone, on targets without std: without a heap and with one. (`targets` links and runs it.)
check_no_std() {
    local target
    export RUSTFLAGS=-Dwarnings
    for target in thumbv7em-none-eabihf riscv32imac-unknown-none-elf x86_64-unknown-none wasm32-unknown-unknown; do
        cargo check --locked -p voxdag --lib --no-default-features --target "$target"
        cargo check --locked -p voxdag --lib --no-default-features --features alloc --target "$target"
    done
}

check_wasm() {
    cargo build --locked -p voxdag-wasm --target wasm32-unknown-unknown
}

# The fuzz targets compile on stable; libFuzzer itself is not built for that.
check_fuzz_builds() {
    CUSTOM_LIBFUZZER_PATH=/nowhere/libfuzzer.a cargo check --locked --manifest-path fuzz/Cargo.toml
}

# The README's first command writes the README's picture, byte for byte, into the current folder.
check_demo() {
    local command='cargo run --release -- demo' folder manifest
    in_readme "$command"
    folder=$(mktemp -d)
    trap "rm -rf '$folder'" EXIT
    (export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
     manifest=$PWD/Cargo.toml
     cd "$folder" && ${command% -- *} --locked --manifest-path "$manifest" -- ${command##* -- })
    cmp "$folder/voxdag-demo.png" docs/demo.png || {
        echo "the demo's picture has changed: look at it, then keep it as docs/demo.png" >&2
        exit 1
    }
}

# The page and the npm package, packed as the README says, in node and in a real browser. Pictures stay in
# target/screenshots to be looked at.
check_web() {
    in_readme 'cargo web build'
    export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
    cargo web build
    cargo run --release --locked -- --version # the page is held against it; as `check_demo` does, so that nothing is compiled again
    if ! command -v npm >/dev/null; then
        echo "SKIPPED: the page's tests, as npm is missing"
        return
    fi
    cd wasm/e2e
    npm ci --no-audit --no-fund
    node --test module.test.mjs
    CHROMIUM=${CHROMIUM:-$(command -v chromium || true)}
    if [ -z "$CHROMIUM" ]; then
        { apt-get update && apt-get install -y --no-install-recommends chromium; } || true
        CHROMIUM=$(command -v chromium || true)
    fi
    if [ -z "$CHROMIUM" ]; then
        echo "SKIPPED: the page in a browser, as chromium is missing (apt-get install chromium)"
        return
    fi
    CHROMIUM=$CHROMIUM node --test page.test.mjs
}

# The oracles against the release build, as users run them.
check_selftest() {
    cargo run --release --locked -- selftest ${1:+--$1}
}

# The README's second command, as it stands there.
check_test() {
    local command='cargo test --workspace'
    in_readme "$command"
    $command
}

# The same words, rays and pixels from every kind of machine code; the hashes stand in tests/golden/src/hashes.rs.
check_targets() {
    local target=${CARGO_TARGET_DIR:-$PWD/target} golden=(--locked -p voxdag-golden) failed=() flags
    export CARGO_TARGET_DIR=$target

    # This machine: unoptimised with all checks, optimised, and with every instruction that its processor has.
    cargo run "${golden[@]}" --config profile.dev.opt-level=0 || failed+=(debug)
    cargo run "${golden[@]}" --release || failed+=(release)
    RUSTFLAGS="-C target-cpu=native" cargo run "${golden[@]}" --release --target-dir "$target/native" || failed+=(native)

    # wasm32 in node, without vectors and with them.
    for flags in "" "-C target-feature=+simd128"; do
        RUSTFLAGS=$flags cargo build "${golden[@]}" --release --target wasm32-unknown-unknown
        node tests/golden/wasm.mjs "$target/wasm32-unknown-unknown/release/voxdag-golden.wasm" || failed+=("wasm32 $flags")
    done

    # A whole program without operating system links elsewhere, too.
    cd tests/bare
    for flags in riscv32imac-unknown-none-elf x86_64-unknown-none; do
        cargo build --locked --profile small --bin picture --features tight --target "$flags"
    done
    # A microcontroller with 32-bit words and f64 in software: a picture in 96 KiB of flash and 8 KiB of RAM, scene and all;
    # from files in flash without a heap; then from the meshes.
    if command -v qemu-system-arm >/dev/null; then
        for flags in "--profile small --bin picture --features tight" "--release --bin draw" \
            "--release --bin pipeline --features heap"; do
            cargo clippy --locked $flags -- -D warnings
            timeout 600 cargo run --locked $flags || failed+=("arm $flags")
        done
    else
        echo "SKIPPED: 32-bit ARM, as qemu-system-arm is missing (apt-get install qemu-system-arm)"
    fi
    if ((${#failed[@]})); then
        printf 'not the same as everywhere: %s\n' "${failed[@]}" >&2
        exit 1
    fi
}

# The shader on a graphics card, or on Mesa's software adapter where that is installed (apt-get install
# mesa-vulkan-drivers), against the exact tracer and the oracles. `long`: ten times as many rays.
check_gpu() {
    local software=(/usr/share/vulkan/icd.d/lvp_icd.*)
    export CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-$PWD/target}"
    # Where the software adapter is installed it must work; without any the program says that it is skipped.
    if [ -e "${software[0]}" ]; then
        export VOXDAG_GPU=required
    fi
    cd tests/gpu
    cargo clippy --locked -- -D warnings
    cargo run --locked -- ${1:+--$1}
}

# In an interpreter that sees undefined behaviour: the core's tests here, and every stage at a small size on a machine that
# stores the high byte first. `long`: both and the smallest golden scene, on those two and on one with 32-bit words.
check_miri() {
    if ! cargo +nightly miri --version >/dev/null 2>&1; then
        echo "SKIPPED: Miri is missing (rustup component add --toolchain nightly miri rust-src)"
        return
    fi
    local core="-p voxdag --lib --features obj" small="-p voxdag-oracle --test small" golden="-p voxdag-golden --lib"
    local here=x86_64-unknown-linux-gnu narrow=i686-unknown-linux-gnu big=s390x-unknown-linux-gnu run
    local runs=("$here $core" "$big $small")
    if [ "${1:-}" = long ]; then
        runs=("$here $core" "$here $small" "$here $golden" "$narrow $core" "$narrow $small" "$narrow $golden"
            "$big $core" "$big $small" "$big $golden")
    fi
    for run in "${runs[@]}"; do
        echo "$run"
        cargo +nightly miri test --quiet --locked --target $run
    done
}

check_fuzz() {
    local seconds=${1:-60} target
    for target in fuzz/fuzz_targets/*.rs; do
        target=$(basename "$target" .rs)
        # New inputs go to a folder that git does not see; the committed ones seed it.
        mkdir -p "fuzz/target/corpus/$target"
        cargo +nightly fuzz run "$target" "fuzz/target/corpus/$target" "fuzz/corpus/$target" "fuzz/regressions/$target" \
            -- -max_total_time="$seconds" -max_len=1024
    done
}

# What the mutants change is still there, once each.
check_mutants_fit() {
    if ! command -v python3 >/dev/null; then
        echo "SKIPPED: whether the mutants fit the sources, as python3 is missing"
        return
    fi
    tests/mutants/run.py --check
}

# Every rule and check taken away in turn: does a test notice? Minutes; python3 needed.
check_mutants() {
    tests/mutants/run.py "$@"
}

check_all() {
    local check failed=() start
    for check in "${ALL[@]}"; do
        echo "== $check"
        start=$SECONDS
        if bash ci.sh "$check"; then
            echo "== $check: ok, $((SECONDS - start)) s"
        else
            echo "== $check: FAILED, $((SECONDS - start)) s"
            failed+=("$check")
        fi
    done
    if ((${#failed[@]})); then
        echo "failed: ${failed[*]}"
        exit 1
    fi
    echo "all checks passed in $SECONDS s"
}

in_readme() {
    grep -qxF "$1" README.md || { echo "README.md does not name the command: $1" >&2; exit 1; }
}

name=${1:-all}
if ! declare -F "check_$name" >/dev/null; then
    echo "no check named $name; there are: all ${ALL[*]} fuzz mutants" >&2
    exit 2
fi
shift || true
"check_$name" "$@"
