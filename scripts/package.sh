#!/usr/bin/env bash
# Builds the Debian packages barrelman, barrelman-media and barrelman-ros2 for the machine's own architecture.
#
#   scripts/package.sh          into target/debian
#   scripts/package.sh DIR      into DIR
#
# The packages need the C library of the machine that they are built on, or a newer one: build on the oldest
# distribution that they are for (docs/install.md).
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:-target/debian}
# Largest size of a package.
max_bytes=12000000
cargo_deb=3.8.0
parts=target/package

scripts/setup.sh media
[ "$(cargo deb --version 2>/dev/null)" = "$cargo_deb" ] || cargo install -q --locked cargo-deb --version "$cargo_deb"

cargo build --profile dist --locked -p barrelman --bins -p barrelman-media -p barrelman-ros2 -p barrelman-manuals
rm -rf "$parts"
mkdir -p "$parts/ros2" "$folder"
# Not by `cargo run`, which would compile the libraries once more, with the features that this program needs.
"${CARGO_TARGET_DIR:-target}/dist/barrelman-manuals" "$parts/manuals"
cargo run -q --locked -p xtask -- licences barrelman barrelman-media > "$parts/licences-of-libraries.txt"
cargo run -q --locked -p xtask -- licences barrelman-ros2 > "$parts/ros2/licences-of-libraries.txt"

# What is new, and Debian's form of it, which names the version.
gzip -9n < CHANGELOG.md > "$parts/changelog.gz"
version=$(cargo metadata --no-deps --format-version 1 | grep -o '"name":"barrelman","version":"[^"]*"' | cut -d'"' -f8)
maintainer=$(grep -m1 '^maintainer' crates/station/Cargo.toml | cut -d'"' -f2)
when=$(git log -1 --format=%cD 2>/dev/null || date -R)
printf 'barrelman (%s-1) unstable; urgency=medium\n\n  * What is new: /usr/share/doc/barrelman/changelog.gz\n\n -- %s  %s\n' \
  "$version" "$maintainer" "$when" > "$parts/debian-changelog"

built=()
for package in barrelman barrelman-media barrelman-ros2; do
  built+=("$(cargo deb -q --locked --no-build --profile dist -p "$package" -o "$folder/")")
done

# What the packages promise each other and their users.
for file in "${built[@]}"; do
  size=$(stat -c %s "$file")
  echo "$file: $size bytes; depends on $(dpkg-deb -f "$file" Depends)"
  [ "$size" -le "$max_bytes" ] || { echo "package: $file is larger than $max_bytes bytes" >&2; exit 1; }
done
wanted="barrelman (= $(dpkg-deb -f "${built[0]}" Version))"
dpkg-deb -f "${built[1]}" Depends | grep -qF "$wanted" || {
  echo "package: crates/media/Cargo.toml must depend on $wanted: both programs are of one build" >&2
  exit 1
}
