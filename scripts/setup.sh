#!/usr/bin/env bash
# Installs the system packages that a step needs, and nothing else. Safe to run again: it asks dpkg first.
#
#   scripts/setup.sh build      a C++ compiler, and nasm (halves the cost of H.264)
#   scripts/setup.sh media      GStreamer: its libraries and plugins, to build and to run barrelman-media
#   scripts/setup.sh test       all of this, what the tests talk to, and what makes the fixtures anew: an RTSP server
#                               (GStreamer), FFmpeg, Chromium for the page and certutil for what it trusts, and
#                               Python with OpenCV, mcap, pytest, ruff and mypy
#   scripts/setup.sh firefox    Firefox and its driver, for the tests of --all that use it
#
# Packages come from Debian (as root, or through sudo) and, for Python, from PyPI into .venv beside this tree.
set -euo pipefail
cd "$(dirname "$0")/.."

need_packages() {
  local missing=()
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "setup: these packages are missing, and there is no sudo: ${missing[*]}" >&2; exit 1; }
    as_root=(sudo)
  fi
  echo "setup: installing ${missing[*]}" >&2
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

need_python() {
  [ -x .venv/bin/python ] || /usr/bin/python3 -m venv --system-site-packages .venv
  # The stamp holds the list that was installed, so that a changed list is installed again.
  if ! cmp -s scripts/requirements.txt .venv/installed.txt; then
    .venv/bin/python -m pip install -q --disable-pip-version-check -r scripts/requirements.txt
    cp scripts/requirements.txt .venv/installed.txt
  fi
}

build=(g++ nasm)
media=(libgstreamer1.0-dev libgstreamer-plugins-base1.0-dev libgstrtspserver-1.0-dev
  gstreamer1.0-plugins-base gstreamer1.0-plugins-good gstreamer1.0-plugins-bad gstreamer1.0-plugins-ugly gstreamer1.0-libav)
test=(python3-venv python3-gi gir1.2-gst-rtsp-server-1.0 gstreamer1.0-tools libgl1 libglib2.0-0 ffmpeg
  chromium chromium-driver libnss3-tools iproute2)

case "${1:-build}" in
  build) need_packages "${build[@]}" ;;
  media) need_packages "${build[@]}" "${media[@]}" ;;
  test) need_packages "${build[@]}" "${media[@]}" "${test[@]}"; need_python ;;
  firefox)
    need_packages firefox-esr
    # The driver is no package of Debian 12.
    command -v geckodriver >/dev/null || cargo install -q --locked geckodriver@0.37.1
    ;;
  *) sed -n '2,10p' "$0" >&2; exit 2 ;;
esac
