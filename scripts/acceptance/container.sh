#!/usr/bin/env bash
# Builds the image of the Dockerfile from the packages, and runs it with podman: the user, the health check,
# the guard, the end. As root; takes 5 minutes and 6 GB, and downloads Debian's packages from the machine's
# mirror.
#
#   scripts/package.sh && scripts/acceptance/container.sh              # on a fresh Debian 12
#   scripts/acceptance/container.sh debian:trixie-slim                 # on an image that podman can pull
#
# Containers have loopback as their only network. Podman keeps everything in a temporary folder.
set -euo pipefail
cd "$(dirname "$0")/../.."
for program in podman crun debootstrap; do
  command -v "$program" >/dev/null || {
    echo "container: there is no $program: apt-get install podman crun debootstrap" >&2
    exit 1
  }
done
[ -e "$(echo target/debian/barrelman-media_*.deb)" ] || {
  echo "container: build the packages first: scripts/package.sh" >&2
  exit 1
}
# crun refuses a machine with both versions of control groups. In a mount namespace it sees one.
if [ -e /sys/fs/cgroup/unified ] && [ -z "${ONE_CGROUP:-}" ]; then
  ONE_CGROUP=1 exec unshare --mount sh -c \
    'umount -R /sys/fs/cgroup; mount -t cgroup2 none /sys/fs/cgroup; exec "$@"' sh "$0" "$@"
fi

work=$(mktemp -d)
export TMPDIR=$work
image=localhost/barrelman
# docs/install.md: how soon the container ends after SIGTERM.
ends_within_s=6

podman_here() {
  podman --root "$work/storage" --runroot "$work/run" --storage-driver vfs --cgroup-manager cgroupfs \
    --events-backend none "$@"
}
clean() {
  podman_here rm --force --all --time 0 >/dev/null 2>&1 || true
  rm -rf "$work"
}
trap clean EXIT
fail() {
  echo "container: $*" >&2
  podman_here logs --tail 20 running >&2 2>/dev/null || true
  exit 1
}
# Limits of the sandboxes that tests run in: no control group, and the hard limits of this shell.
start() {
  podman_here run --cgroups disabled --ulimit nofile=1024:1024 --ulimit nproc=2000:2000 "$@"
}
inside() {
  podman_here exec running "$@"
}
until_true() {
  local what=$1
  shift
  for _ in $(seq 300); do
    "$@" >/dev/null 2>&1 && return
    sleep 0.1
  done
  fail "not within 30 s: $what"
}
is_healthy() {
  podman_here healthcheck run running
}
# Stops the container as `docker stop` does, and says how long it took.
stop() {
  local began=$EPOCHREALTIME took
  podman_here stop --time 30 running >/dev/null
  took=$(awk -v began="$began" -v ended="$EPOCHREALTIME" 'BEGIN { print ended - began }')
  echo "  ended $took s after SIGTERM"
  [ "$(podman_here inspect --format '{{.State.ExitCode}}' running)" = 0 ] || fail "the end was not in order"
  awk -v took="$took" -v limit="$ends_within_s" 'BEGIN { exit took > limit }' || fail "it ended too late"
}

image_is_built() {
  local base=${1:-localhost/debian}
  if [ -z "${1:-}" ]; then
    debootstrap --variant=minbase bookworm "$work/base" >"$work/debootstrap" 2>&1 ||
      { tail -5 "$work/debootstrap"; fail "no base image"; }
    tar -C "$work/base" -c . | podman_here import --quiet - "$base" >/dev/null
    rm -rf "$work/base"
  fi
  podman_here build --isolation chroot --layers=false --format docker --build-arg "BASE=$base" \
    --tag "$image" . >"$work/build" 2>&1 || { tail -20 "$work/build"; fail "the image was not built"; }
  echo "  $(podman_here image inspect --format '{{.Size}}' "$image") bytes"
}

user_is_not_root() {
  local user groups
  user=$(start --rm --network none --no-healthcheck --entrypoint id "$image" -u)
  groups=$(start --rm --network none --no-healthcheck --entrypoint id "$image" -Gn)
  [ "$user" -ne 0 ] || fail "the program runs as root"
  [[ $groups == *dialout* && $groups == *video* ]] || fail "no serial ports or cameras for the groups $groups"
}

doctor_finds_guard_and_decoders_and_names_the_container() {
  local said word
  said=$(start --rm --network none --no-healthcheck "$image" doctor) || fail "doctor: $said"
  for word in /usr/bin/barrelman-guard H.265 "PID namespace"; do
    [[ $said == *"$word"* ]] || fail "doctor does not name $word: $said"
  done
}

demo_is_healthy_until_it_hangs() {
  start --detach --name running --network none "$image" >/dev/null
  until_true "the demo is healthy" is_healthy
  [ "$(inside curl -fsk https://127.0.0.1:8480/healthz)" = ok ] || fail "the demo does not answer"
  inside pkill -STOP --exact barrelman
  is_healthy >/dev/null 2>&1 && fail "a demo that hangs is healthy"
  inside pkill -CONT --exact barrelman
  until_true "the demo is healthy again" is_healthy
  stop
  podman_here rm running >/dev/null
}

# A run with a simulated boat, and in another container an emulated vehicle whose camera turns. The run's
# console is on loopback.
drive() {
  local state=$1
  mkdir -m 777 "$state"
  start --detach --name vehicle --network none --no-healthcheck --volume "$state:/log" "$image" \
    emulate fotokite-pro --listen 127.0.0.1:5760 --log /log/vehicle >/dev/null
  until_true "the vehicle runs" test -e "$state/vehicle"
  start --detach --name running --network container:vehicle "$image" run --no-record \
    --listen 127.0.0.1:8480 --video 'sim:arena1?size=320x240' --link tcp://127.0.0.1:5760 \
    --console-token-file tokens >/dev/null
  until_true "the run is healthy" is_healthy
  token=$(inside head -1 tokens)
  until_true "the link is up" asked status '"state":"up"'
  until_true "the run takes the control" asked requests '"accepted"' '{"request":{"kind":"take-control"}}'
  until_true "the boat is tracked" asked status '"state":"tracking"'
  until_true "the run engages" asked requests '"accepted"' '{"request":{"kind":"engage"}}'
  until_true "the camera turns" turns "$state/vehicle"
}
asked() {
  inside curl -fs -H "Authorization: Bearer $token" -H 'Content-Type: application/json' ${3:+--data "$3"} \
    "http://127.0.0.1:8480/api/v1/$1" | tr -d ' \n' | grep -qF "$2"
}
# Whether the last rates in force are other than zero.
turns() {
  python3 - "$1" <<'PYTHON'
import json, sys
rows = open(sys.argv[1]).read().rpartition("\n")[0].splitlines()
state = json.loads(rows[-1])["state"]
sys.exit(not (state["yaw_rate"] or state["pitch_rate"]))
PYTHON
}

guard_outlives_a_killed_program() {
  local state=$work/killed code
  drive "$state"
  inside pkill -KILL --full '^barrelman run'
  code=$(podman_here wait running)
  [ "$code" = 137 ] || fail "the container ended with $code"
  turns "$state/vehicle" && fail "the camera turns on"
  podman_here rm running >/dev/null
  podman_here rm --force --time 0 vehicle >/dev/null
}

run_ends_with_zeros() {
  local state=$work/stopped
  drive "$state"
  stop
  turns "$state/vehicle" && fail "the camera turns on"
  podman_here rm running >/dev/null
  podman_here rm --force --time 0 vehicle >/dev/null
}

for check in "image_is_built ${1:-}" user_is_not_root \
  doctor_finds_guard_and_decoders_and_names_the_container demo_is_healthy_until_it_hangs \
  guard_outlives_a_killed_program run_ends_with_zeros; do
  echo "${check% }"
  $check
done
echo "the container holds"
