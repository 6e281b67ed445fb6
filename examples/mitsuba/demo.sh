#!/usr/bin/env bash
# Judges three samplers of Mitsuba on three cases: installs it from PyPI into a folder of its own, exports, renders, verifies.
#
#   examples/mitsuba/demo.sh [--quick] [DIR]
#
# DIR (default target/mitsuba) gets the virtual environment, the images and a report (README.md, CSV tables). --quick leaves out
# the sweep. The program is $ETENDUE, or built here. Expected: `independent` and `multijitter` pass everywhere, `stratified`
# fails on the open disk. Exit codes: 0 as expected, 1 otherwise, 77 skipped (no Python, or PyPI is out of reach).
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
quick=
[[ "${1:-}" == --quick ]] && { quick=--quick; shift; }
dir="${1:-$here/../../target/mitsuba}"
version=3.9.1

skip() {
    echo "SKIPPED: the Mitsuba demonstration did not run: $*" >&2
    exit 77
}

mkdir -p "$dir"
dir="$(cd "$dir" && pwd)"
if ! "$dir/venv/bin/python" -c 'import mitsuba, numpy' 2>/dev/null; then
    command -v python3 >/dev/null || skip "there is no python3"
    rm -rf "$dir/venv"
    python3 -m venv "$dir/venv" 2>"$dir/pip.log" || skip "python3 -m venv failed ($dir/pip.log)"
    "$dir/venv/bin/pip" install --quiet --disable-pip-version-check --retries 1 --timeout 20 "mitsuba==$version" numpy \
        >>"$dir/pip.log" 2>&1 || skip "pip install mitsuba==$version failed; is PyPI within reach? ($dir/pip.log)"
fi
if [[ -z "${ETENDUE:-}" ]]; then
    (cd "$here/../.." && cargo build --quiet --release)
    ETENDUE="$(cd "$here/../.." && pwd)/target/release/etendue"
fi
exec "$dir/venv/bin/python" "$here/demo.py" --etendue "$ETENDUE" --dir "$dir" $quick
