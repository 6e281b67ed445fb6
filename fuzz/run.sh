#!/usr/bin/env bash
# Bytes that nobody wrote, through every reader of what others wrote: no panic, no hang, no more memory than said.
#
#   fuzz/run.sh [EXECUTIONS [TARGET…]]      3,000,000 in all unless said otherwise, dealt out by the shares below
#
# A line for each target, then a total; exit code 1 where something was found: the input then lies in fuzz/artifacts/TARGET.
# Mend it, and keep the input in tests/data/fuzz/TARGET, where `cargo test --lib fuzzing` feeds it to the same reader.
# Needs nightly Rust, `cargo install cargo-fuzz --locked`, and a C++ compiler. SANITIZER=none is quicker, SEED=1 another walk.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# target     share  longest  seconds an input may take (what is quick gets many)
TARGETS="
case          600     4096     10
obj          1500     4096     10
png           400     4096     10
pfm          1600     2048     10
npy          1600     2048     10
exr           300     4096     10
manifest      400     4096     10
estimates    1600     4096     10
units         200     4096     10
points       1750     4096     10
report         45     8192     20
plots           5     8192     20
"
# Mebibytes that a process may take, the fuzzer's own included.
MEMORY=2048

executions=${1:-3000000}
shift || true
chosen=("$@")
sanitizer=${SANITIZER:-address}
triple=$(rustc -vV | sed -n 's/^host: //p')

# Inputs to begin with: what is kept, what is shipped, and the tables of the reference run, some rows of each.
seeds() {
    local target=$1 into=fuzz/corpus/$1
    mkdir -p "$into" "fuzz/artifacts/$target"
    if compgen -G "tests/data/fuzz/$target/*" >/dev/null; then cp tests/data/fuzz/"$target"/* "$into"; fi
    case $target in
        case) cp cases/*/*.toml assets/new-case.toml "$into" ;;
        png) cp cases/texture/*.png "$into" ;;
        plots) cp tests/data/fuzz/report/* "$into" ;;
    esac
    case $target in
        report | plots)
            for case in penumbra/eclipse direct/turning-patch; do
                for table in manifest.json convergence.csv means.csv rates.csv curves.csv correlation.csv energy.csv caustic.csv \
                    texels.csv paths.csv scene.csv verdicts.csv; do
                    [[ -f reports/reference/$table ]] || continue
                    echo "=$table"
                    if [[ $table == *.json ]]; then cat "reports/reference/$table"; else
                        head -1 "reports/reference/$table"
                        grep -m 6 "^$case," "reports/reference/$table" || true
                    fi
                done >"$into/${case//\//-}"
            done
            ;;
    esac
}

# Words of a format, from the papers that are held to the code.
words() {
    case $1 in
        case) grep -oh '`[a-z_]*`' docs/reference/case-files.md | tr -d '`' ;;
        obj) printf '%s\n' 'v 0 0 1' 'f 1 2 3' 'f -1 -2 -3' '1//1' '1/1/1' 'vn ' 'usemtl ' 1e30 nan ;;
        pfm) printf '%s\n' 'Pf' 'PF' '-1.0' '2 2' '1 1' '3 2' ;;
        npy) printf '%s\n' "'descr': '<f4'" "'fortran_order': False" "'shape': (2, 2)" '(1, 2, 2, 3)' '>f8' '<f2' True ;;
        manifest) grep -oh '"[a-z_]*"' tests/data/fuzz/manifest/*.json | tr -d '"' | sort -u ;;
        estimates | points) printf '%s\n' '0,0,1,0.5' '0.25 0.75' nan inf 1e308 18446744073709551615 '# ' ;;
        report | plots) head -qn 1 reports/reference/*.csv | tr ',' '\n' | tr -d '\r' | sort -u ;;
    esac | sed 's/["\\]/\\&/g; s/.*/"&"/' | grep -v '^""$' >"fuzz/corpus/$1.dict" || true
}

is_chosen() { [[ ${#chosen[@]} == 0 || " ${chosen[*]} " == *" $1 "* ]]; }
# The shares of those that are chosen, together.
whole=0
while read -r target share _; do
    if [[ -n $target ]] && is_chosen "$target"; then whole=$((whole + share)); fi
done <<<"$TARGETS"
[[ $whole -gt 0 ]] || { echo "no such target; there are$(awk 'NF { printf " %s", $1 }' <<<"$TARGETS")" >&2; exit 2; }

cargo +nightly fuzz build --fuzz-dir fuzz -s "$sanitizer"

total=0 findings=0 begin=$SECONDS
printf '%-10s %12s %8s %10s %9s\n' target executions seconds 'per second' findings
while read -r target share longest seconds; do
    [[ -n $target ]] || continue
    is_chosen "$target" || continue
    runs=$((executions * share / whole))
    seeds "$target"
    words "$target"
    dictionary=()
    if [[ -s fuzz/corpus/$target.dict ]]; then dictionary=(-dict="fuzz/corpus/$target.dict"); fi
    before=$(find "fuzz/artifacts/$target" -type f | wc -l) started=$SECONDS log=fuzz/artifacts/$target.log
    fuzz/target/"$triple"/release/"$target" -runs="$runs" -max_len="$longest" -timeout="$seconds" -rss_limit_mb=$MEMORY \
        -malloc_limit_mb=$MEMORY "${dictionary[@]}" -artifact_prefix="fuzz/artifacts/$target/" \
        -print_final_stats=1 -close_fd_mask=1 -seed="${SEED:-0}" "fuzz/corpus/$target" >"$log" 2>&1 </dev/null || true
    took=$((SECONDS - started))
    done=$(sed -n 's/^stat::number_of_executed_units: *//p' "$log" | tail -1)
    found=$(($(find "fuzz/artifacts/$target" -type f | wc -l) - before))
    [[ -n $done ]] || found=$((found > 0 ? found : 1))
    total=$((total + ${done:-0})) findings=$((findings + found))
    printf '%-10s %12d %8d %10d %9d\n' "$target" "${done:-0}" "$took" $((${done:-0} / (took > 0 ? took : 1))) "$found"
done <<<"$TARGETS"
printf '%-10s %12d %8d %10s %9d\n' total "$total" $((SECONDS - begin)) '' "$findings"
[[ $findings == 0 ]]
