#!/usr/bin/env bash
# etendue beside Embree and Mitsuba 3, on this machine, one thread each: ours and theirs by turns, and the median of the
# ratios of the rounds. Other work on the machine moves rates by factors; ratios of neighbouring runs far less.
#
#   benches/peers/compare.sh [ROUNDS]      five unless said otherwise; about ten minutes
#
# Needs, beside Rust: a C compiler and Embree 3 (Debian: libembree-dev); Python 3 and PyPI for Mitsuba, LLVM 19 (Debian:
# libllvm19). What is missing is left out and said. Nothing is installed outside target/peers.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
rounds="${1:-5}" place=target/peers
mkdir -p "$place"

cargo bench --bench ours --no-run --message-format=json 2>/dev/null >"$place/build.json"
ours=$(grep -o '"executable":"[^"]*ours-[^"]*"' "$place/build.json" | tail -1 | cut -d'"' -f4)
[[ -x "$ours" ]] || { echo "error: cargo bench --bench ours --no-run built nothing" >&2; exit 1; }

embree="$place/embree"
cc -O3 -march=native benches/peers/embree.c -o "$embree" -lembree3 -lm 2>/dev/null || embree=""
python="$place/venv/bin/python"
if [[ ! -x "$python" ]]; then
    python3 -m venv "$place/venv" && "$place/venv/bin/pip" install -q mitsuba==3.9.1 numpy || python=""
fi
[[ -n "$python" ]] && ! "$python" benches/peers/mitsuba_room.py a 1024 >/dev/null 2>&1 && python=""

# Processes from their start to a relative standard error of 1e-3 in mid-penumbra: medians of milliseconds.
processes() {
    local mine theirs begin ratios=""
    for ((round = 0; round < rounds; round++)); do
        begin=$(date +%s%N); "$ours" target c 1e-3 >/dev/null; mine=$((($(date +%s%N) - begin) / 1000))
        begin=$(date +%s%N); "$python" benches/peers/mitsuba_room.py c 0 1e-3 >/dev/null 2>&1; theirs=$((($(date +%s%N) - begin) / 1000))
        ratios+="$((theirs * 100 / mine)) $mine $theirs"$'\n'
    done
    sort -n <<<"${ratios%$'\n'}" | awk '{ ratio[NR] = $1 / 100; mine[NR] = $2 / 1e3; theirs[NR] = $3 / 1e3 }
        END { m = int((NR + 1) / 2)
              printf "| a process, from start to a standard error of 1e-3 in mid-penumbra (c) | %.1f ms | %.0f ms | **%.0f** | %.0f to %.0f |\n",
                     mine[m], theirs[m], ratio[m], ratio[1], ratio[NR] }'
}

rate() { grep -o '"m[a-z]*_per_s": *[0-9.]*' | head -1 | tr -d ' ' | cut -d: -f2; }

# What is compared, and the two commands: `rounds` times one after the other.
alternate() {
    local what="$1" mine="$2" theirs="$3" lines=""
    for ((round = 0; round < rounds; round++)); do
        lines+="$(eval "$mine" | rate) $(eval "$theirs" | rate)"$'\n'
    done
    sort -n <<<"$(awk 'NF == 2 { print $1 / $2, $1, $2 }' <<<"$lines")" | awk -v what="$what" '
        { ratio[NR] = $1; mine[NR] = $2; theirs[NR] = $3 }
        END { m = int((NR + 1) / 2)
              printf "| %s | %.1f | %.1f | **%.2f** | %.2f to %.2f |\n", what, mine[m], theirs[m], ratio[m], ratio[1], ratio[NR] }'
}

echo "Machine: $(grep -m1 'model name' /proc/cpuinfo | cut -d: -f2 | xargs), $(nproc) processors; $(date -u +%F); $rounds rounds, one thread."
echo
echo "| | etendue (f64), million/s | the other (f32), million/s | ratio: median | of all rounds |"
echo "|---|---|---|---|---|"
if [[ -n "$embree" ]]; then
    for triangles in 100000 1000000; do
        for mesh in disk sphere; do
            for order in random strat; do
                alternate "shadow rays, $mesh of $triangles triangles, $order, Embree 3 \`rtcOccluded1\`" \
                    "'$ours' rays $mesh $triangles $order" "'$embree' $mesh $triangles $order"
            done
        done
    done
else
    echo "| Embree: left out (no compiler, or no libembree-dev) | | | | |"
fi
if [[ -n "$python" ]]; then
    for room in "a 65536 disk" "d 65536 disk behind disk" "c 65536 rectangle behind rectangle" "e 16384 rectangle behind 100,128 triangles"; do
        read -r letter samples name <<<"$room"
        alternate "samples, $name, Mitsuba 3.9.1 LLVM" \
            "'$ours' room $letter $samples" "'$python' benches/peers/mitsuba_room.py $letter $samples 2>/dev/null"
    done
    processes
else
    echo "| Mitsuba: left out (no PyPI, or no LLVM 19) | | | | |"
fi
