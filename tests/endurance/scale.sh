#!/usr/bin/env bash
# A thousand shards: how long they take to merge, how large they are, and what a study of 10^12 samples would take by that.
#
#   tests/endurance/scale.sh [N] [CASE…]    default 1000 shards of the shipped cases at --quick
#   ETENDUE=path/to/etendue                 the program (default: target/release/etendue)
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
ETENDUE=$(readlink -f "${ETENDUE:-$root/target/release/etendue}")
[[ -x $ETENDUE ]] || { echo "no program: cargo build --release" >&2; exit 2; }
n=${1:-1000}
shift || true
work=$(mktemp -d "${TMPDIR:-/tmp}/etendue-scale.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2

study=("$@" --quick --allow-undecided)
now() { echo $((${EPOCHREALTIME/./} / 1000)); }
timed() { # words, command
    local words=$1 begun
    shift
    begun=$(now)
    "$@" || { echo "FAILED: $words"; exit 1; }
    echo "$words: $(($(now) - begun)) ms"
}
quietly() { "$@" >/dev/null 2>said || { cat said; false; }; }
timed "one run" quietly "$ETENDUE" run "${study[@]}" --out whole --quiet
shard() { "$ETENDUE" run "${@:2}" --shard "$1/$n" --out parts --threads 1 --quiet >/dev/null; }
export -f shard
export ETENDUE n
timed "$n shards, $(nproc) at a time" quietly xargs -a <(seq 0 $((n - 1))) -P "$(nproc)" -I {} bash -c 'shard "$@"' shard {} "${study[@]}"
echo "files: $(ls parts | wc -l), $(du -sb parts | cut -f1) bytes; the largest $(ls -lS parts | awk 'NR == 2 { print $5 }')"
rm parts/shard-00003-of-*.units
timed "what is missing, found" bash -c "! '$ETENDUE' merge parts --out merged --quiet >/dev/null 2>said && grep -q 'missing: 3' said"
shard 3 "${study[@]}"
timed "merging, tables alone" quietly "$ETENDUE" merge parts --out merged --quiet --no-plots --allow-undecided
timed "merging, with plots, pictures and page" quietly "$ETENDUE" merge parts --out merged --quiet --allow-undecided
timed "the same report" diff -rq whole merged --exclude='timings*'
