#!/usr/bin/env bash
# Every call of the system that writes is made to fail once: `strace` has the N-th return an error, for each N. The run has to say
# so, without a panic, and to come to its end when it goes on; or it has come there all the same (a checkpoint is no condition).
#
#   tests/endurance/faults.sh [MOST]    of each call at most so many places, spread evenly (default 40)
#   ETENDUE=path/to/etendue             the program (default: target/release/etendue)
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
ETENDUE=$(readlink -f "${ETENDUE:-$root/target/release/etendue}")
[[ -x $ETENDUE ]] || { echo "no program: cargo build --release" >&2; exit 2; }
command -v strace >/dev/null || { echo "skipped: no strace"; exit 77; }
strace -o /dev/null true 2>/dev/null || { echo "skipped: strace may not look on here"; exit 77; }
most=${1:-40}
work=$(mktemp -d "${TMPDIR:-/tmp}/etendue-faults.XXXXXX")
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 2

study=(penumbra/half-plane caustic/paraboloid --quick --threads 1 --allow-undecided)
"$ETENDUE" run "${study[@]}" --out whole --quiet >/dev/null || exit 2

# What goes wrong where: a full disk, a quota, a disk that fails, a file system that has become read-only, a folder that is gone,
# no more files, no more memory (which ends the program: the system's way of saying so, and ours).
faults=(write:ENOSPC write:EDQUOT write:EIO openat:EROFS openat:EMFILE rename:EIO rename:ENOENT mkdir:ENOSPC unlink:EROFS fsync:EIO ftruncate:EIO mmap:ENOMEM)
declare -A forgiven=([unlink]='.*')
tried=0 told=0 unharmed=0 wrong=0
for mode in run shard; do
    if [[ $mode == run ]]; then words=(--out out); else words=(--out out --shard 0/1); fi
    for fault in "${faults[@]}"; do
        call=${fault%:*} error=${fault#*:}
        calls=$call
        [[ $call == rename ]] && calls=rename,renameat,renameat2
        [[ $call == mkdir ]] && calls=mkdir,mkdirat
        [[ $call == unlink ]] && calls=unlink,unlinkat
        [[ $call == fsync ]] && calls=fsync,fdatasync
        rm -rf out
        strace -f -qq -e trace="$calls" -o calls "$ETENDUE" run "${study[@]}" --quiet "${words[@]}" >/dev/null 2>&1
        count=$(grep -c "(" calls)
        step=$(((count + most - 1) / most))
        for ((k = 1; k <= count; k += step > 0 ? step : 1)); do
            rm -rf out
            # The shell's own word on a program that is ended by a signal goes nowhere.
            { (
                strace -f -qq -e trace="$calls" -e inject="$calls:error=$error:when=$k" -o calls \
                    "$ETENDUE" run "${study[@]}" --quiet "${words[@]}" >said.out 2>said
                exit $?
            ); } 2>/dev/null
            code=$?
            tried=$((tried + 1))
            problem=
            # Without memory for a thread or its stack, panicking is how the standard library ends the program.
            [[ $call != mmap ]] && grep -q "panicked" said && problem="a panic"
            case $code in
                0 | 3) unharmed=$((unharmed + 1)) ;;
                2 | 5 | 75) [[ -s said ]] && told=$((told + 1)) || problem="exit code $code without a word" ;;
                # Before the program is loaded, or out of memory.
                *) [[ $call == openat || $call == mmap ]] && told=$((told + 1)) || problem="exit code $code" ;;
            esac
            if [[ -z $problem ]]; then
                [[ $code == 0 ]] || "$ETENDUE" run "${study[@]}" --quiet "${words[@]}" --resume >/dev/null 2>said || problem="it does not go on"
                report=out
                if [[ $mode == shard ]]; then
                    report=merged
                    rm -rf merged
                    "$ETENDUE" merge out --out merged --quiet --allow-undecided >/dev/null 2>said || problem="it cannot be merged"
                fi
                # Where nothing can be removed, a passing file stays: its name is hidden, and nobody reads it.
                diff -rq whole "$report" --exclude='timings*' ${forgiven[$call]:+--exclude=${forgiven[$call]}} >difference ||
                    problem="another report: $(head -2 difference)"
            fi
            if [[ -n $problem ]]; then
                wrong=$((wrong + 1))
                echo "$mode, $call number $k of $count fails with $error: $problem"
                tail -n 3 said
            fi
        done
        echo "$mode: $fault at $count calls, $SECONDS s"
    done
done
echo "$tried faults: $told told with an exit code, $unharmed without harm, $wrong wrong, in $SECONDS s"
[[ $wrong == 0 ]]
