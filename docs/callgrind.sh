#!/usr/bin/env bash
# Instructions per ray, normal, look-up and voxel: the core's benchmarks under callgrind, which counts only inside `kernel`.
#
# One pass of each benchmark. Needs valgrind and jq.
set -euo pipefail
cd "$(dirname "$0")/.."
for tool in valgrind jq; do
    command -v "$tool" >/dev/null || { echo "callgrind.sh: $tool is missing" >&2; exit 1; }
done
bench=$(cargo bench --no-run -p voxdag --bench core --message-format json 2>/dev/null |
    jq -r 'select(.executable != null and .target.name == "core") | .executable')
[ -x "$bench" ] || { echo "callgrind.sh: the benchmarks did not build" >&2; exit 1; }

# NAME OF THE BENCHMARK, KERNEL, WHAT IT HAS AS MANY ITEMS AS, NAME OF AN ITEM
count() {
    local out=$work/out items instructions
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect="core::kernel::$2*" \
        "$bench" --test --exact "$1" >"$out" 2>&1
    items=$(sed -n "s/.*\b\([0-9]\+\) $3.*/\1/p" "$out" | head -n 1)
    instructions=$(sed -n 's/.*Collected : \([0-9]\+\).*/\1/p' "$out")
    awk -v name="$1" -v n="$instructions" -v items="$items" -v unit="${4:-${3%s}}" \
        'BEGIN { printf "| %s | %.1f a %s | %d |\n", name, n / items, unit, items }'
}

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
echo "| benchmark | instructions | items |"
echo "| --- | ---: | ---: |"
count core::primary::Exact trace rays
count core::primary::F64 trace rays
count core::primary_without_top trace rays
count core::primary_ssvdag trace rays
count core::shadow occluded hits
for kind in Face Gradient Plane1 Plane2 Plane3; do count "core::normals::$kind" normals hits; done
count core::look_up look_up rays look-up
count core::look_up_tree look_up rays look-up
count core::voxelize voxelize voxels
count core::reduce reduce voxels
count core::build::None build voxels
count core::build::Table build voxels
