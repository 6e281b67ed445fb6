#!/usr/bin/env bash
# The league: released renderers, held against exact irradiance, each in a virtual environment of its own.
#
#   tests/league/run.sh [--quick] [--only WITNESS[,WITNESS]] [--case CASE] [--seed-set N] [--jobs J] [--no-report]
#
# Everything: some 90 minutes on two cores and 2.5 GB of disk. --quick: Mitsuba, Radiance, raysect and POV-Ray on a few cases, under
# five minutes; verdicts are compared with expected.csv. What is finished is kept in $LEAGUE_DIR (default target/league), so
# that a run that was cut short goes on where it stopped. The program is $ETENDUE, or built here; $PYTHON a Python 3.11 (Blender's
# wheel knows no other). POV-Ray is no Python package: apt-get install povray.
# Exit codes: 0 verdicts as expected, 1 a verdict changed, 77 nothing could be set up.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
root="$(cd "$here/../.." && pwd)"
dir="${LEAGUE_DIR:-$root/target/league}"
python="${PYTHON:-$(command -v python3.11 || command -v python3 || true)}"
[[ -n "$python" ]] || { echo "SKIPPED: there is no python3" >&2; exit 77; }

witnesses="mitsuba radiance raysect povray luxcore cycles"
report=1 only='' arguments=()
while (($#)); do
    case "$1" in
    --no-report) report=; shift; continue ;;
    --quick) witnesses="mitsuba radiance raysect povray"; report= ;;
    --only) only="${2//,/ }" ;;
    esac
    arguments+=("$1")
    shift
done

# An environment that is whole says so; one that was cut short is made anew.
environment() {
    local name="$1" place="$dir/venv/$1" wants="$here/requirements/$1.txt"
    cmp --silent "$wants" "$place/ready" && return
    echo "setting up $name" >&2
    rm -rf "$place"
    mkdir -p "$dir/venv"
    "$python" -m venv "$place" >"$dir/venv/$name.log" 2>&1 &&
        "$place/bin/pip" install --quiet --disable-pip-version-check --retries 1 --timeout 30 -r "$wants" >>"$dir/venv/$name.log" 2>&1 &&
        cp "$wants" "$place/ready"
}
mkdir -p "$dir"
environment league || { echo "SKIPPED: numpy cannot be installed ($dir/venv/league.log)" >&2; exit 77; }
for witness in ${only:-$witnesses}; do
    [[ "$witness" == etendue ]] || environment "$witness" || echo "NOT INSTALLED: $witness ($dir/venv/$witness.log)" >&2
done
if [[ -z "${ETENDUE:-}" ]]; then
    (cd "$root" && cargo build --quiet --release)
    ETENDUE="$root/target/release/etendue"
fi
status=0
"$dir/venv/league/bin/python" "$here/league.py" --etendue "$ETENDUE" --dir "$dir" ${arguments[@]+"${arguments[@]}"} || status=$?
[[ -z "$report" ]] || "$dir/venv/league/bin/python" "$here/report.py" --etendue "$ETENDUE" --dir "$dir" --out "$root/reports/league"
exit $status
