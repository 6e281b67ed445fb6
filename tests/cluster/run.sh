#!/usr/bin/env bash
# A study on a cluster that is lost and found again: Slurm on this machine alone, nodes that lose power, files that are damaged
# or gone; what is merged in the end is what one run writes, byte for byte. The README's section is followed word for word.
#
#   tests/cluster/run.sh        a minute or two; ends with `N passed, N failed`; 77 where there is no Slurm, or no root
#   ETENDUE=path/to/etendue     the program (default: target/release/etendue)
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
source "$root/tests/cluster/slurm.sh"
ETENDUE=${ETENDUE:-$root/target/release/etendue}
[[ -x $ETENDUE ]] || { echo "no program at $ETENDUE: cargo build --release" >&2; exit 2; }
why=$(cluster_has_tools) || { echo "skipped: $why (apt-get install -y --no-install-recommends munge slurmctld slurmd slurm-client)"; exit 77; }

work=$(mktemp -d "${TMPDIR:-/tmp}/etendue-study.XXXXXX")
trap 'cluster_down; rm -rf "$work"' EXIT
trap 'exit 130' INT TERM
cd "$work" || exit 2
# `etendue`, as the README has it.
mkdir bin
ln -s "$(readlink -f "$ETENDUE")" bin/etendue
PATH=$work/bin:$PATH
unset ETENDUE

passed=0 failed=0 began=$SECONDS
check() { # words, then a command
    local words=$1
    shift
    if "$@"; then
        passed=$((passed + 1))
        echo "ok      $((SECONDS - began)) s  $words"
    else
        failed=$((failed + 1))
        echo "FAILED  $((SECONDS - began)) s  $words"
    fi
}
queue_empty() { [[ -z $(squeue -h 2>/dev/null) ]]; }
same() { # two reports, but for the timings
    diff -rq "$1" "$2" --exclude='timings*' >"$work/difference" && [[ $(find "$1" -type f | wc -l) -gt 10 ]] || { head -5 "$work/difference"; false; }
}
fails_with() { # exit code, log, words that it says
    local code=$1 log=$2
    shift 2
    local word
    for word; do grep -qF -- "$word" "$log" || { echo "not said: $word"; cat "$log"; return 1; }; done
    [[ -n $code ]]
}
job_code() { scontrol show job "$1" 2>/dev/null | sed -n 's/.*ExitCode=\([0-9]*\):.*/\1/p' | head -1; }

cluster_up 3 || { echo "the cluster does not come up" >&2; tail -n 5 "$CLUSTER"/log/* >&2; exit 2; }
echo "        $((SECONDS - began)) s  three nodes are up"

# The README's section, word for word: what follows its mark, one command a line.
mapfile -t said < <(awk '/^<!-- a study on a cluster/ { marked = 1; next } marked && /^```sh$/ { inside = 1; next }
                         inside && /^```$/ { exit } inside { sub(/ +#.*/, ""); print }' "$root/README.md")
[[ ${#said[@]} -ge 3 ]] || { echo "the README's commands were not found" >&2; exit 2; }
for command in "${said[@]}"; do
    check "README: $command" eval "$command"
    wait_for 240 queue_empty || echo "the queue does not empty"
done
etendue run penumbra --out single --quiet >/dev/null
check "the README's report is that of one run" same single study/report

# The same again, while things go wrong.
etendue plan penumbra -n 30 --for slurm -o lost >/dev/null
job=$(sbatch --parsable lost/shards.sbatch)
busy() { [[ -n $(squeue -h -w n2 -t R -o %A 2>/dev/null) && $(ls lost/parts 2>/dev/null | wc -l) -ge 4 ]]; }
check "a node is at work" wait_for 60 busy
node_down n2
check "the node is missed" wait_for 60 eval '[[ $(sinfo -h -n n2 -o %T) == down* ]]'
node_up n2
check "what it ran is sent again, and all ends" wait_for 240 queue_empty
requeued=$(grep -c "requeue" "$CLUSTER/log/slurmctld")
check "some tasks were requeued ($requeued lines)" test "$requeued" -gt 0
check "30 shards are there" test "$(ls lost/parts | grep -c '^shard-')" -eq 30
rm lost/parts/shard-00007-of-00030.units
printf '\xff' | dd of=lost/parts/shard-00012-of-00030.units bs=1 seek=3000 conv=notrunc status=none
truncate -s -100 lost/parts/shard-00013-of-00030.units
merge=$(sbatch --parsable lost/merge.sbatch)
wait_for 60 queue_empty
check "merging fails with 6" test "$(job_code "$merge")" = 6
check "and names what is missing and damaged" fails_with 6 lost/logs/merge.txt "missing: 7,12-13" "--array=7,12-13" \
    "shard-00012-of-00030.units is damaged" "shard-00013-of-00030.units is damaged"
array=$(grep -o -- '--array=[0-9,-]*' lost/logs/merge.txt | head -1)
# One of them twice at once, on two nodes.
sbatch --parsable -w n1 "$array" lost/shards.sbatch >/dev/null
check "they are sent again as it says: lost/submit.sh $array" eval "lost/submit.sh $array >/dev/null"
check "and end" wait_for 120 queue_empty
check "the report is that of one run: nothing lost, nothing counted twice" same single lost/report
check "nothing is left but the shards" test "$(ls -A lost/parts | grep -vc '^shard-')" -eq 0

echo "$passed passed, $failed failed in $((SECONDS - began)) s"
[[ $failed == 0 ]]
