#!/usr/bin/env bash
# Installs the packages in fresh Debian systems, uses them, and runs the service under systemd. As root; takes
# a quarter of an hour and 3 GB for each release, and downloads Debian's packages from the machine's mirror.
#
#   scripts/package.sh && scripts/acceptance/packages.sh              # Debian 12
#   scripts/acceptance/packages.sh bookworm trixie                    # Debian 12 and 13
#
# The folder of the systems is $ROOTS, or a temporary one that is removed at the end. The programs in the
# systems reach loopback alone.
set -euo pipefail
cd "$(dirname "$0")/../.."
mirror=$(sed -n 's/^URIs: *//p; s/^deb \(\[.*\] \)\?\(http[^ ]*debian\)\/\? .*/\2/p' \
  /etc/apt/sources.list /etc/apt/sources.list.d/*.sources 2>/dev/null | grep -m1 debian || true)
mirror=${mirror:-http://deb.debian.org/debian}
needed=(debootstrap systemd-nspawn lintian)
for program in "${needed[@]}"; do
  command -v "$program" >/dev/null || {
    echo "packages: there is no $program: apt-get install debootstrap systemd-container lintian" >&2
    exit 1
  }
done
packages=(target/debian/barrelman_*.deb target/debian/barrelman-media_*.deb target/debian/barrelman-ros2_*.deb)
[ -e "${packages[2]}" ] || { echo "packages: build them first: scripts/package.sh" >&2; exit 1; }

if [ -z "${ROOTS:-}" ]; then
  ROOTS=$(mktemp -d)
  trap 'rm -rf "$ROOTS"' EXIT
fi

# The same packages once more with the next revision and another configuration file, for the upgrade.
make_upgrade() {
  local file version content
  for file in "${packages[@]}"; do
    content=$(mktemp -d)
    dpkg-deb -R "$file" "$content"
    version=$(dpkg-deb -f "$file" Version)
    sed -i "s/^Version: .*/Version: ${version%-*}-2/; s/(= $version)/(= ${version%-*}-2)/" "$content/DEBIAN/control"
    if [ -e "$content/etc/barrelman/barrelman.toml" ]; then
      echo '# A later version says more.' >> "$content/etc/barrelman/barrelman.toml"
    fi
    dpkg-deb -b --root-owner-group -Zgzip -z1 "$content" "$1/" >/dev/null
    rm -rf "$content"
  done
}

# Runs a command in a system, with loopback as its only network.
in_system() {
  local root=$1
  shift
  unshare --net -- sh -c 'ip link set lo up; exec "$@"' sh chroot "$root" "$@"
}

try() {
  local release=$1 root=$ROOTS/$1
  echo "== $release: a fresh system"
  [ -x "$root/usr/bin/apt-get" ] || debootstrap --variant=minbase \
    --include=ca-certificates,curl,dbus,libpam-systemd,polkitd,procps,python3,systemd,systemd-sysv,udev "$release" "$root" "$mirror" >/dev/null
  chroot "$root" dpkg --purge barrelman-media barrelman-ros2 barrelman >/dev/null 2>&1 || true
  rm -rf "$root/acceptance" "$root/var/lib/barrelman"
  mkdir -p "$root/acceptance/upgrade"
  cp "${packages[@]}" scripts/acceptance/packaged_service.py "$root/acceptance/"
  make_upgrade "$root/acceptance/upgrade"

  echo "== $release: apt install"
  mount --bind /proc "$root/proc"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  chroot "$root" sh -c 'export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq && apt-get install -y -qq --no-install-recommends /acceptance/*.deb' >"$root/acceptance/apt" 2>&1 ||
    { tail -20 "$root/acceptance/apt"; umount "$root/proc"; exit 1; }
  in_system "$root" barrelman --version
  in_system "$root" barrelman-ros2 --version
  in_system "$root" barrelman check | tee "$root/acceptance/check"
  grep -q 'H.265' "$root/acceptance/check" || { echo "packages: no decoder of H.265" >&2; umount "$root/proc"; exit 1; }
  in_system "$root" sh -ec 'cd /tmp
    timeout 20 barrelman demo --seconds 15 >/acceptance/demo 2>&1 &
    for _ in $(seq 100); do curl -fs http://127.0.0.1:8480/healthz && break; sleep 0.1; done
    curl -fs http://127.0.0.1:8480/ | grep -i "<title>"
    wait' || { cat "$root/acceptance/demo"; umount "$root/proc"; exit 1; }
  umount "$root/proc"

  echo "== $release: the service"
  cat > "$root/etc/systemd/system/acceptance.service" <<UNIT
[Unit]
After=multi-user.target
[Service]
Type=oneshot
ExecStart=/usr/bin/python3 -u /acceptance/packaged_service.py
ExecStopPost=/bin/systemctl --no-block poweroff
StandardOutput=file:/acceptance/printed
StandardError=inherit
TimeoutStartSec=600
UNIT
  mkdir -p "$root/etc/systemd/system/multi-user.target.wants"
  ln -sf ../acceptance.service "$root/etc/systemd/system/multi-user.target.wants/acceptance.service"
  timeout 900 systemd-nspawn -q -b -D "$root" --register=no --keep-unit --private-network --console=pipe \
    >"$root/acceptance/console" 2>&1 </dev/null || true
  cat "$root/acceptance/printed" || tail -20 "$root/acceptance/console"
  grep -q '^all checks passed' "$root/acceptance/printed"
}

lintian --fail-on error --tag-display-limit 0 "${packages[@]}"
for release in "${@:-bookworm}"; do
  try "$release"
done
echo "the packages hold"
