#!/usr/bin/env bash
# Twenty minutes at full load: memory flat, throughput flat, and not a watt lost.
#
#   tests/endurance/soak.sh [SECONDS]    default 1200; ends with the figures, and what 10^12 samples would take
#   ETENDUE=path/to/etendue              the program (default: target/release/etendue)
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
ETENDUE=$(readlink -f "${ETENDUE:-$root/target/release/etendue}")
[[ -x $ETENDUE ]] || { echo "no program: cargo build --release" >&2; exit 2; }
seconds=${1:-1200}
work=$(mktemp -d "${TMPDIR:-/tmp}/etendue-soak.XXXXXX")
trap 'kill "${id:-}" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 2

# Two rooms side by side, each with half of the threads: shadow rays into a penumbra, and light through a ball of glass. One
# strategy: one after the other, a slower one would look like a decline.
rooms() { # replicates, rays
    mkdir -p rooms
    { cat "$root/cases/penumbra/eclipse.toml" && printf '\n[study]\nstrategies = ["stratified"]\nsamples = [1024]\nreplicates = %s\n' "$1"; } >rooms/shadow.toml
    sed "s/^\[light\].*/[light]\nrays = $2/" "$root/cases/caustic/glass-ball.toml" >rooms/glass.toml
    grep -q "^rays = $2" rooms/glass.toml || { echo "the light's rays were not set" >&2; exit 2; }
}
timed() { # stage: rays, seconds of processor time
    awk -F, -v stage="$1" 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i } $column["stage"] == stage { r += $column["rays"]; s += $column["seconds"] }
                           END { print r, s }' out/timings.csv
}
rooms 2000 20000000
"$ETENDUE" run rooms --out out --no-plots --quiet --allow-undecided >/dev/null || exit 2
threads=$(nproc)
read -r shadow_rays shadow_seconds < <(timed measure)
read -r light_rays light_seconds < <(timed light)
half=$(awk -v n="$threads" 'BEGIN { print n / 2 }')
replicates=$(awk -v t="$seconds" -v r="$shadow_rays" -v s="$shadow_seconds" -v h="$half" 'BEGIN { printf "%.0f", 2000 * t * h / s }')
# Three runs: a sixteenth, a quarter, all. Light's seconds are those on the clock.
rays=$(awk -v t="$seconds" -v r="$light_rays" -v s="$light_seconds" 'BEGIN { printf "%.0f", r / s * t / 1.3125 }')
rooms "$replicates" "$rays"
echo "shadow rays: $replicates replicates of 1024 samples at each point; light: $rays rays; about $seconds s on $threads threads"

# What this machine does just before, and just after: a neighbour of a rented one comes and goes.
speed() {
    "$ETENDUE" run penumbra/eclipse --samples 1024 --strategy stratified --replicates 200000 --no-plots --quiet --out speed >/dev/null 2>&1
    awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i } $column["stage"] == "measure" { print $column["rays"] / $column["seconds"] }' speed/timings.csv
}
before=$(speed)
"$ETENDUE" run rooms --out out --no-plots --progress plain --allow-undecided >verdicts 2>progress &
id=$!
: >memory
while kill -0 "$id" 2>/dev/null; do
    awk -v t="$SECONDS" '/^VmRSS/ { print t, $2 }' "/proc/$id/status" >>memory 2>/dev/null
    sleep 2
done
wait "$id"
code=$?
after=$(speed)
echo "exit code $code after $SECONDS s in all"
tail -n 3 verdicts

failed=0
fail() { echo "FAILED: $*"; failed=1; }
[[ $code == 0 ]] || fail "exit code $code: $(tail -n 2 progress)"
# Memory: the largest of the last quarter against the largest of the second.
awk '{ t[NR] = $1; kb[NR] = $2 } END {
    for (i = 1; i <= NR; i++) { q = int(4 * (i - 1) / NR); if (kb[i] > most[q]) most[q] = kb[i] }
    printf "memory, most in each quarter: %.1f %.1f %.1f %.1f MiB\n", most[0] / 1024, most[1] / 1024, most[2] / 1024, most[3] / 1024
    exit !(most[3] <= 1.05 * most[1] + 1024) }' memory || fail "memory grows"
# Throughput: the log has a line each ten seconds, with the mean rate so far. Only while both rooms are at work.
awk -v before="$before" -v after="$after" '/^0\/2 cases/ && match($0, /[0-9.]+ (thousand |million |billion )?rays\/s/) {
         split(substr($0, RSTART, RLENGTH), w, " ")
         traced[++n] = 10 * n * w[1] * (w[2] == "billion" ? 1e9 : w[2] == "million" ? 1e6 : w[2] == "thousand" ? 1e3 : 1)
     }
     END {
         if (n < 16) { print "too few lines to tell"; exit 1 }
         printf "million rays/s in each eighth:"
         for (k = 1; k <= 8; k++) {
             to = int(n * k / 8)
             rate = (traced[to] - (k > 1 ? traced[from] : 0)) / (10 * (to - (k > 1 ? from : 0)))
             printf " %.0f", rate / 1e6
             from = to
             if (k <= 2) early += rate
             if (k >= 7) late += rate
         }
         kept = late / early / (after / before)
         printf "\nthe last quarter over the first: %.3f; the machine itself, after over before: %.3f\n", late / early, after / before
         exit !(kept >= 0.95)
     }' progress || fail "throughput is not flat"
awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
         { gap = $column["residual_W"] / $column["source_power_W"]; if (gap < 0) gap = -gap; if (gap > worst) worst = gap }
         END { printf "books: %.1e of the power is unaccounted for at most\n", worst; exit !(worst <= 1e-12) }' out/energy.csv || fail "watts are lost"
read -r shadow_rays shadow_seconds < <(timed measure)
read -r light_rays light_seconds < <(timed light)
awk -v r="$shadow_rays" -v s="$shadow_seconds" -v lr="$light_rays" -v ls="$light_seconds" 'BEGIN {
    printf "%.3g shadow samples at %.0f million/s a core, %.3g light rays at %.2f million/s\n", r, r / s / 1e6, lr, lr / ls / 1e6
    printf "10^12 such samples: %.0f core hours\n", 1e12 / (r / s) / 3600 }'
[[ $failed == 0 ]]
