#!/usr/bin/env bash
# CPU seconds (user + system) that the slim build takes as a dependency of an empty project, crate by crate, on one job.
#
#   benches/slim_build.sh [FEATURE,…]      features besides none, such as `fast` or `studies`
#
# CARGO_INCREMENTAL=0 is what cargo does with crates from a registry; etendue stands here as a path.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

mkdir "$work/src"
cat >"$work/Cargo.toml" <<TOML
[package]
name = "slim-user"
version = "0.0.0"
edition = "2024"
[dependencies]
etendue = { path = "$root", default-features = false, features = [$(sed 's/[^,][^,]*/"&"/g' <<<"${1:-}")] }
[workspace]
TOML
cat >"$work/src/main.rs" <<'RUST'
use etendue::{Case, Draws, judge};

fn main() {
    let case = Case::shipped("penumbra/eclipse").unwrap();
    let mine = |draws: &mut Draws, points: &mut [[f64; 2]]| points.fill_with(|| [draws.unit(), draws.unit()]);
    judge(&case).quick().points("mine", &mine).assert_passes();
}
RUST
# The versions that the repository is tested with.
cp "$root/Cargo.lock" "$work/"

cat >"$work/timed" <<'SH'
#!/usr/bin/env bash
name=other previous=
for word in "$@"; do
    [[ $previous == --crate-name ]] && name=$word
    previous=$word
done
TIMEFORMAT="%U %S $name"
{ time "$@" 2>&3; } 3>&2 2>>"$TIMES"
SH
chmod +x "$work/timed"

cd "$work"
cargo fetch --quiet
export CARGO_INCREMENTAL=0 CARGO_TARGET_DIR="$work/target" TIMES="$work/times" RUSTC_WRAPPER="$work/timed"
cargo build --quiet --offline -j1
awk '{ of[$3] += $1 + $2; all += $1 + $2 }
     END { for (name in of) printf "%7.2f  %s\n", of[name], name; printf "%7.2f  all\n", all }' "$TIMES" | sort -rn
"$CARGO_TARGET_DIR/debug/slim-user" && echo "and it judges"
