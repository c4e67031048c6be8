#!/usr/bin/env bash
# Sets up whatever the tests need, and runs them: the crates' own, and the program as a whole against an
# emulated ground station, a real RTSP server, OpenCV and Python's readers. Needs no network after the set-up.
#
#   scripts/test.sh          all but the long ones
#   scripts/test.sh --all    the long ones, too: each case in all its variants
set -euo pipefail
cd "$(dirname "$0")/.."
# Of the acceptance tests, by their marks (pyproject.toml).
case "$*" in
  "") chosen="not strict and not long" ;;
  --all) chosen="not strict" ;;
  *) sed -n '2,6p' "$0" >&2; exit 2 ;;
esac
scripts/setup.sh test

if cargo nextest --version >/dev/null 2>&1; then
  cargo nextest run --workspace
  # nextest does not run the examples in the documentation.
  cargo test --quiet --workspace --doc --no-fail-fast
else
  cargo test --workspace
fi

# Of the whole workspace: with the features of the tests, so that nothing is compiled again.
cargo build --workspace --bin barrelman --bin barrelman-guard --bin barrelman-media --bin barrelman-ros2
# One practice clip for all of them, and what they printed.
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# Runs the acceptance tests with a mark.
accept() {
  local marks=$1
  shift
  .venv/bin/pytest scripts/acceptance -q --barrelman target/debug/barrelman --clip "$folder/practice" \
    --durations=15 -m "$marks and $chosen" "$@" | tee -a "$folder/printed"
}

# Most tests mostly wait. Those that drive a vehicle leave no time for a film beside them.
accept "not realtime and not alone" -n 3 --dist loadgroup
accept "realtime and not alone" -n 2 --dist loadgroup
accept "alone"
echo "not judged, as the machine stood still: $(grep -c ': not judged: ' "$folder/printed" || true)"
