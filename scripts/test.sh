#!/usr/bin/env bash
# Sets up whatever the tests need, and runs all of them: the crates' own, and the program as a whole against an
# emulated ground station, a real RTSP server, OpenCV and Python's readers. Needs no network after the set-up.
set -euo pipefail
cd "$(dirname "$0")/.."
scripts/setup.sh test

if cargo nextest --version >/dev/null 2>&1; then
  cargo nextest run --workspace
  # nextest does not run the examples in the documentation.
  cargo test --quiet --workspace --doc --no-fail-fast
else
  cargo test --workspace
fi

# Of the whole workspace: with the features of the tests, so that nothing is compiled again.
cargo build --workspace --bin barrelman --bin barrelman-guard
program=target/debug/barrelman
# One practice clip for all of them.
clip=$(mktemp -d)
# The process group of what runs beside the script, while it runs.
beside=
clean_up() {
  [[ -z $beside ]] || kill -- "-$beside" 2>/dev/null || true
  rm -rf "$clip"
}
trap clean_up EXIT
"$program" demo --clip --draw-only --force --output "$clip"
with_clip="--clip $clip"

# Runs acceptance scripts, each given with its options, one after the other; stops at the first that fails.
run_in_order() {
  local script name
  for script in "$@"; do
    # shellcheck disable=SC2086  # the words after a script's name are its options
    set -- $script
    name=$1; shift
    printf '\n== scripts/acceptance/%s.py %s\n' "$name" "$*"
    .venv/bin/python "scripts/acceptance/$name.py" --barrelman "$program" "$@" || return
  done
}

# Starts acceptance scripts that run beside those of the next `run_in_front`.
start_beside() {
  # A process group of its own (job control): its programs obey SIGINT, and it ends with this script.
  set -m
  run_in_order "$@" >"$clip/beside.txt" 2>&1 &
  beside=$!
  set +m
}

# Runs acceptance scripts, and waits for those beside them.
run_in_front() {
  local in_front=0 at_once=0
  run_in_order "$@" || in_front=$?
  wait "$beside" || at_once=$?
  beside=
  cat "$clip/beside.txt"
  ((in_front == 0 && at_once == 0))
}

# What needs one core and no exact times runs beside what mostly waits.
start_beside "first_hour"
run_in_front "law" "rule $with_clip" "bad_input $with_clip" "kills --count 3 $with_clip" "live --restarts 2" "rtsps" "hostile_servers" \
  "camshift $with_clip" "tracking_camera" "api" "reconnect" "campaigns --trials 100"
# What measures times that leave little room, alone.
run_in_order "guard --few $with_clip" "stops $with_clip"
# Vehicles: these mostly wait, ...
start_beside "mavlink_gimbal"
run_in_front "sigma" "mavlink_boat"
# ... and these give the machine half a second where they measure times.
start_beside "vessel"
run_in_front "drive"
# What needs both cores.
run_in_order "floods --short" "console" "console_cost --seconds 4"
