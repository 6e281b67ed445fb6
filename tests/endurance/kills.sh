#!/usr/bin/env bash
# Runs that are killed at random moments, and go on: every one has to come to the bytes of a run that nobody disturbed.
#
#   tests/endurance/kills.sh [N]    default 200: three of five by SIGKILL, one each by SIGINT and SIGTERM; every fourth is killed
#                                   once more while it goes on, every fifth is a shard that is merged; some ten minutes
#   ETENDUE=path/to/etendue         the program (default: target/release/etendue)
#   SEED=7                          of the moments
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
ETENDUE=$(readlink -f "${ETENDUE:-$root/target/release/etendue}")
[[ -x $ETENDUE ]] || { echo "no program: cargo build --release" >&2; exit 2; }
n=${1:-200}
RANDOM=${SEED:-7}
work=$(mktemp -d "${TMPDIR:-/tmp}/etendue-kills.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2

# Small cells and large ones, pilots, rays from the light, eye paths, plots and a page.
study=(penumbra/half-plane penumbra/eclipse-mesh caustic/glass-ball interreflection/coaxial-disks
    --quick --strategy "random,correlated,uniform-jitter" --allow-undecided)
"$ETENDUE" run "${study[@]}" --out warm --quiet >/dev/null || exit 2
start=${EPOCHREALTIME/./}
"$ETENDUE" run "${study[@]}" --out whole --quiet >/dev/null || exit 2
whole=$((${EPOCHREALTIME/./} - start))
echo "undisturbed: $((whole / 1000)) ms"

# Ends a command at a random moment of an undisturbed run's time, and a tenth after it.
disturbed() { # signal, words
    local signal=$1 moment
    shift
    moment=$((whole * (RANDOM % 1100) / 1000))
    "$ETENDUE" run "${study[@]}" --quiet "$@" >/dev/null 2>>"$work/said" &
    local id=$!
    sleep "$(printf '%d.%06d' $((moment / 1000000)) $((moment % 1000000)))"
    kill "-$signal" "$id" 2>/dev/null && cut=$((cut + 1))
    wait "$id" 2>/dev/null
}
signals=(KILL KILL INT KILL TERM)
same=0 cut=0
for ((k = 1; k <= n; k++)); do
    rm -rf out parts
    if ((k % 5)); then words=(--out out); else words=(--out parts --shard 0/1); fi
    disturbed "${signals[k % 5]}" "${words[@]}"
    if ((k % 4 == 0)); then disturbed KILL "${words[@]}" --resume; fi
    "$ETENDUE" run "${study[@]}" --quiet "${words[@]}" --resume >/dev/null 2>>said || echo "kill $k: the run that goes on fails: $?"
    if ((k % 5 == 0)); then "$ETENDUE" merge parts --out out --quiet --allow-undecided >/dev/null 2>>said || echo "kill $k: merging fails: $?"; fi
    if diff -rq whole out --exclude='timings*' >difference; then same=$((same + 1)); else echo "kill $k:" && cat difference; fi
    left=$(find out parts -name '*.partial' -o -name '.lock' 2>/dev/null)
    [[ -z $left ]] || { echo "kill $k: left behind: $left" && same=$((same - 1)); }
    grep -q panicked said && { echo "kill $k: a panic" && cat said && exit 1; }
done
echo "$same of $n killed runs came to the same bytes ($cut signals found a run under way) in $SECONDS s"
[[ $same == "$n" ]]
