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

# Two rooms side by side, each with half of the threads: shadow rays into a penumbra, and light through a ball of glass.
rooms() { # replicates, rays
    mkdir -p rooms
    { cat "$root/cases/penumbra/eclipse.toml" && printf '\n[study]\nstrategies = ["random", "stratified"]\nsamples = [1024]\nreplicates = %d\n' "$1"; } >rooms/shadow.toml
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
replicates=$(awk -v t="$seconds" -v r="$shadow_rays" -v s="$shadow_seconds" -v h="$half" 'BEGIN { printf "%d", 2000 * t * h / s }')
# Three runs: a sixteenth, a quarter, all. Light's seconds are those on the clock.
rays=$(awk -v t="$seconds" -v r="$light_rays" -v s="$light_seconds" 'BEGIN { printf "%d", r / s * t / 1.3125 }')
rooms "$replicates" "$rays"
echo "shadow rays: $replicates replicates of 1024 samples at 65 points, twice; light: $rays rays; about $seconds s on $threads threads"

"$ETENDUE" run rooms --out out --no-plots --progress plain --allow-undecided >verdicts 2>progress &
id=$!
: >memory
while kill -0 "$id" 2>/dev/null; do
    awk -v t="$SECONDS" '/^VmRSS/ { print t, $2 }' "/proc/$id/status" >>memory 2>/dev/null
    sleep 2
done
wait "$id"
code=$?
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
# Throughput: rays that the log tells, from line to line.
awk 'match($0, /[0-9.]+ [kMG]? ?rays\/s/) { split(substr($0, RSTART, RLENGTH), w, " "); f = w[2] == "G" ? 1e9 : w[2] == "M" ? 1e6 : w[2] == "k" ? 1e3 : 1; n++; rate[n] = w[1] * f }
     END { if (n < 8) { print "too few lines to tell"; exit 1 }
           printf "throughput so far, at a quarter, half, three quarters, the end of the log: %.4g %.4g %.4g %.4g rays/s\n", rate[int(n/4)], rate[int(n/2)], rate[int(3*n/4)], rate[n-1] }' progress || fail "no throughput in the log"
awk -F, 'NR == 1 { for (i = 1; i <= NF; i++) column[$i] = i; next }
         { gap = $column["residual_W"] / $column["source_power_W"]; if (gap < 0) gap = -gap; if (gap > worst) worst = gap }
         END { printf "books: %.1e of the power is unaccounted for at most\n", worst; exit !(worst <= 1e-12) }' out/energy.csv || fail "watts are lost"
read -r shadow_rays shadow_seconds < <(timed measure)
read -r light_rays light_seconds < <(timed light)
awk -v r="$shadow_rays" -v s="$shadow_seconds" -v lr="$light_rays" -v ls="$light_seconds" 'BEGIN {
    printf "%.3g shadow samples at %.0f million/s a core, %.3g light rays at %.2f million/s\n", r, r / s / 1e6, lr, lr / ls / 1e6
    printf "10^12 such samples: %.0f core hours\n", 1e12 / (r / s) / 3600 }'
[[ $failed == 0 ]]
