#!/usr/bin/env bash
# A thousand shards: how long they take to merge, how large they are, and what a study of 10^12 samples would take by that.
#
#   tests/endurance/scale.sh [N] [CASE…]    default 1000 shards of the shipped cases at --quick: 25 minutes on two cores, of
#                                           `penumbra` alone four
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

# 10^12 samples: the penumbras with as many replicates as that takes, planned; of the shards some are made.
model=(penumbra --strategy "random,correlated,stratified" --samples 1024 --replicates)
planned() { "$ETENDUE" plan "${model[@]}" "$1" -n 1000 --json 2>/dev/null; }
told() { awk -v key="\"$1\":" '$1 == key { sub(/,$/, "", $2); sum += $2; if ($2 > most) most = $2 } END { printf "%.17g %.17g\n", sum, most }'; }
read -r rays _ < <(planned 1000 | told rays)
replicates=$(awk -v r="$rays" 'BEGIN { printf "%.0f", 1e12 / r * 1000 }')
planned "$replicates" >plan.json
read -r rays _ < <(told rays <plan.json)
# Seconds of the plans come before those of the shards.
sed '1,/"shards"/d' plan.json >of-shards.json
read -r seconds longest < <(told seconds <of-shards.json)
read -r units most < <(told units <of-shards.json)
made=0 bytes=0 took=0
for index in 1 334 667 998; do
    begun=$(now)
    "$ETENDUE" run "${model[@]}" "$replicates" --shard "$index/1000" --out trillion --threads 1 --quiet >/dev/null || { echo "FAILED: shard $index"; exit 1; }
    took=$((took + $(now) - begun)) made=$((made + 1))
done
bytes=$(cat trillion/*.units | wc -c)
awk -v r="$rays" -v s="$seconds" -v l="$longest" -v u="$units" -v m="$most" -v n="$made" -v b="$bytes" -v t="$took" 'BEGIN {
    printf "%.3g shadow samples (%s units) in 1000 shards: planned %.1f core hours, the longest shard %.0f s\n", r, u, s / 3600, l
    printf "%d of the shards, made: %.1f s and %.0f kB each; all: %.1f core hours, 1000 files, %.1f MB\n", n, t / n / 1e3, b / n / 1e3, t / n * 1000 / 3.6e6, b / n * 1000 / 1e6 }'
