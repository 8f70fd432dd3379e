#!/usr/bin/env bash
# voxdag against Embree's rtcIntersect1 and rtcOccluded1 on the source triangles: same rays, same run, one thread. Rays
# in random directions have the same starts, and directions of the same distribution.
#
#   docs/embree/compare.sh SCENES [ROUNDS] [FLAGS OF voxdag bench trace, such as --level avx2]
#
# SCENES is a folder with bunny/bunny.obj, dragon/dragon.obj, sponza/sponza.obj and conference/conference.obj. Each
# round runs ours and Embree's after each other with 3 repetitions; the table has the medians of ROUNDS (5) rounds and
# the median of the rounds' ratios. Needs a C compiler, jq, and Embree 3 (Debian: apt-get install libembree-dev).
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
scenes=${1:?folder with the scenes}
rounds=${2:-5}
flags=("${@:3}")
resolution=${RESOLUTION:-1024}

for tool in cc jq cargo; do
    command -v "$tool" >/dev/null || { echo "compare.sh: $tool is missing" >&2; exit 1; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! echo '#include <embree3/rtcore.h>' | cc -E - >/dev/null 2>&1; then
    echo "compare.sh: Embree 3 is absent, nothing was compared. Debian and Ubuntu: apt-get install libembree-dev" >&2
    exit 1
fi
cc -O3 -march=native -o "$work/embree" "$here/compare.c" -lembree3 -lm
cargo build --release --manifest-path "$here/../../Cargo.toml" -p voxdag-cli
voxdag=${CARGO_TARGET_DIR:-$here/../../target}/release/voxdag

median() { sort -g | awk '{ x[NR] = $1 } END { print (x[int((NR + 1) / 2)] + x[int(NR / 2) + 1]) / 2 }'; }

# NAME OBJ FOV EYE TARGET; `-` leaves the eye to the default view.
compare() {
    local name=$1 obj=$scenes/$2 fov=$3 eye=$4 target=$5 camera=(--fov "$3") round
    [ "$eye" = - ] || camera+=(--eye "$eye" --target "$target")
    local scene=$work/$(basename "$obj" .obj).vxd
    [ -e "$scene" ] || "$voxdag" build "$obj" -o "$scene" -r "$resolution" --materials none >/dev/null 2>&1
    rm -f "$work"/*.json
    for ((round = 0; round < rounds; round++)); do
        "$voxdag" bench trace "$scene" --repeat 3 --json "${camera[@]}" "${flags[@]}" >"$work/ours.$round.json"
        "$work/embree" "$obj" 1920x1080 3 "$fov" "$eye" "$target" >"$work/theirs.$round.json"
    done
    local row=$name kind ours theirs ratio
    for kind in primary shadow random; do
        ours=$(jq ".$kind.mrays_per_s" "$work"/ours.*.json | median)
        theirs=$(jq ".$kind.mrays_per_s" "$work"/theirs.*.json | median)
        ratio=$(for ((round = 0; round < rounds; round++)); do
            jq -s ".[0].$kind.mrays_per_s / .[1].$kind.mrays_per_s" "$work/ours.$round.json" "$work/theirs.$round.json"
        done | median)
        row+=$(printf ' | %.2f | %.2f | %.3f' "$ours" "$theirs" "$ratio")
        row+=$(printf ' | %.4f / %.4f' "$(jq ".$kind.hit_fraction" "$work/ours.0.json")" \
            "$(jq ".$kind.hit_fraction" "$work/theirs.0.json")")
    done
    echo "| $row |"
}

# A point of the mesh's box: shares of its extent along x, y and z.
inside() {
    local info
    info=$("$voxdag" info "$1" --json 2>/dev/null)
    jq -r --argjson at "$2" '.box as $b | [range(3) | $b.min[.] + $at[.] * ($b.max[.] - $b.min[.])] | map(tostring) |
        join(",")' <<<"$info"
}

echo "| camera, $resolution^3 | primary: voxdag Mrays/s | Embree Mrays/s | ratio | hit, ours / Embree's |" \
    "shadow: voxdag | Embree | ratio | blocked, ours / Embree's |" \
    "random: voxdag | Embree | ratio | hit, ours / Embree's |"
echo "| --- | ---: | ---: | ---: | --- | ---: | ---: | ---: | --- | ---: | ---: | ---: | --- |"
compare "bunny 0" bunny/bunny.obj 45 - -
# 53.13 degrees: a field as high as its distance.
compare "bunny 1" bunny/bunny.obj 53.13 0,0,32 0,0,0
compare "dragon 0" dragon/dragon.obj 45 - -
for name in sponza conference; do
    "$voxdag" build "$scenes/$name/$name.obj" -o "$work/$name.vxd" -r "$resolution" --materials none >/dev/null 2>&1
    compare "$name 2" "$name/$name.obj" 60 "$(inside "$work/$name.vxd" '[0.12, 0.25, 0.5]')" \
        "$(inside "$work/$name.vxd" '[1, 0.25, 0.5]')"
done
