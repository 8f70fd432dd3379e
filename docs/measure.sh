#!/usr/bin/env bash
# The figures of performance.md that need no Embree: docs/measure.sh SCENES [MORE FLAGS FOR voxdag bench]
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
bunny=${1:?folder with the scenes}/bunny/bunny.obj
cargo build --release --manifest-path "$here/../Cargo.toml" -p voxdag-cli
voxdag=${CARGO_TARGET_DIR:-$here/../target}/release/voxdag

run() {
    echo "== voxdag bench $*"
    "$voxdag" bench "$@"
}

run trace "$bunny" -r 1024 --materials none "${@:2}"
run trace "$bunny" -r 1024 --materials none --eye 0,0,32 --target 0,0,0 --fov 53.13 "${@:2}"
run normals "$bunny" -r 1024 "${@:2}"
run materials "$bunny" -r 1024 "${@:2}"
run build "$bunny" -r 1024 "${@:2}"
for name in bunny sponza conference; do
    run accuracy "$1/$name/$name.obj" -r 512 "${@:2}"
done
"$here/callgrind.sh"
