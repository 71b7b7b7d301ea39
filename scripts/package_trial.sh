#!/usr/bin/env bash
# Installs the Debian package in a Debian 12 root, uses what it gives as three users, and purges it.
# Usage: scripts/package_trial.sh --root DIR [--deb FILE] [--mirror URL] [--no-boot] [--keep]
# DIR is a Debian 12 root and is not changed: all happens on an overlay of it that goes away (--keep: it
# stays, and its place is said). Is DIR empty or not there, debootstrap makes it, from URL if given.
# Without --deb the package is made from build/release. Needs root, for mounts and a chroot.
# Tried: apt-get install; the man pages; `sixdial doctor`; a collection from the mock rig and its report as
# a user in the group sixdial; that a user outside it gets nothing; purge, and what is left.
# The root is booted by its own systemd in namespaces of its own, the package installed there, and its
# socket unit enabled as an administrator would. That needs systemd in the root and control groups of
# version 2 that may be written; where it cannot be had, and with --no-boot, the service is started as the
# package's user without systemd, on the same paths. "FIGURE trial.booted" says which (1 or 0).
set -euo pipefail
source=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)

root="" deb="" mirror="" boot=1 keep=0
die() { printf 'package_trial: %s\n' "$*" >&2; exit 1; }
arguments=("$@")
while [ $# -gt 0 ]; do
  case $1 in
    --root | --deb | --mirror) declare "${1#--}=${2:?$1 needs a value}"; shift 2 ;;
    --no-boot) boot=0; shift ;;
    --keep) keep=1; shift ;;
    -h | --help) sed -n '2,/^set -/{s/^# //p}' "$0"; exit 0 ;;
    *) die "unknown option $1; see --help" ;;
  esac
done
[ -n "$root" ] || die "give the Debian 12 root: --root DIR; see --help"
[ "$(id -u)" = 0 ] || die "run as root: it mounts and enters another root"

# Everything below is in namespaces of its own: mounts and processes end with it.
if [ "${PACKAGE_TRIAL_INSIDE:-}" != yes ]; then
  PACKAGE_TRIAL_INSIDE=yes exec unshare --mount --pid --fork --kill-child --uts --ipc --mount-proc \
    --propagation private "$source/scripts/package_trial.sh" "${arguments[@]}"
fi

if [ ! -e "$root/etc/debian_version" ]; then
  echo "== debootstrap of Debian 12 in $root"
  debootstrap --variant=minbase --include=systemd,ca-certificates,adduser bookworm "$root" ${mirror:+"$mirror"}
fi
grep -q '^12' "$root/etc/debian_version" || die "$root is no Debian 12"
if [ -z "$deb" ]; then
  echo "== the package, from build/release"
  rm -f "$source"/build/release/*.deb
  (cd "$source/build/release" && cpack -G DEB --config CPackConfig.cmake >cpack.log) || die "see build/release/cpack.log"
  deb=$(find "$source/build/release" -maxdepth 1 -name '*.deb' | head -1)
fi
[ -f "$deb" ] || die "no package $deb"

work=$(mktemp -d /var/tmp/sixdial-trial-XXXXXX)
top=$work/root
cleanup() {
  local group=$work/groups/sixdial-trial-$$
  if [ -d "$group" ]; then
    echo 1 >"$group/cgroup.kill" 2>/dev/null || true
    for _ in $(seq 50); do
      find "$group" -depth -type d -exec rmdir {} \; 2>/dev/null || true
      [ -d "$group" ] || break
      sleep 0.1
    done
    umount "$work/groups"
  fi
  jobs -p | xargs -r kill 2>/dev/null || true
  umount -R "$top" 2>/dev/null || umount -lR "$top"
  if [ "$keep" = 1 ]; then
    echo "kept: $work"
  else
    rm -rf --one-file-system "$work"
  fi
}
trap cleanup EXIT
mkdir "$work/upper" "$work/work" "$top"
mount -t overlay overlay -o "lowerdir=$root,upperdir=$work/upper,workdir=$work/work" "$top"
mount -t proc proc "$top/proc"
mount -t tmpfs -o mode=755 tmpfs "$top/run"
mount -t tmpfs -o mode=1777 tmpfs "$top/tmp"
mount -t tmpfs -o mode=755 tmpfs "$top/dev"
for device in null zero full random urandom tty; do
  touch "$top/dev/$device" && mount --bind "/dev/$device" "$top/dev/$device"
done
mkdir "$top/dev/pts" "$top/dev/shm"
mount -t devpts -o newinstance,ptmxmode=0666,mode=620,gid=5 devpts "$top/dev/pts"
ln -s pts/ptmx "$top/dev/ptmx"
rm -f "$top/etc/resolv.conf"
cp /etc/resolv.conf "$top/etc/resolv.conf" 2>/dev/null || true
cp "$deb" "$top/opt/sixdial.deb"
printf '#!/bin/sh\nexit 101\n' >"$top/usr/sbin/policy-rc.d" && chmod 755 "$top/usr/sbin/policy-rc.d"

checks=0 failures=0
check() {  # what, command ...
  local what=$1
  shift
  checks=$((checks + 1))
  if "$@" >"$work/check.log" 2>&1; then
    echo "ok    $what"
  else
    failures=$((failures + 1))
    echo "WRONG $what"
    tail -15 "$work/check.log" | sed 's/^/      /'
  fi
}
leader=""  # the booted root's first process
inside() {
  local way=(chroot "$top")
  [ -n "$leader" ] && way=(nsenter --all --target "$leader")
  "${way[@]}" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}
as() {  # user, shell line: as that user with its groups, at home
  inside setpriv --reuid "$1" --regid "$1" --init-groups sh -c "cd /home/$1 && export HOME=/home/$1 && $2"
}
says() { "${@:2}" 2>&1 | grep -q -- "$1"; }
fails() { ! "$@"; }
socket_mode() { [ "$(stat -c %a "$top/run/sixdial/sixdiald.sock")" = 660 ]; }

try_boot() {
  [ -x "$top/lib/systemd/systemd" ] || { echo "no systemd in the root"; return 1; }
  local groups=$work/groups container
  mkdir "$groups" && mount -t cgroup2 cgroup2 "$groups" && mkdir "$groups/sixdial-trial-$$" || return 1
  (
    echo "$BASHPID" >"$groups/sixdial-trial-$$/cgroup.procs"
    # What of the kernel is everybody's stays as it is: /proc/sys and /sys are read-only.
    TOP=$top exec unshare --cgroup --pid --mount --uts --ipc --fork --kill-child --propagation private sh -c '
      mount -t proc proc "$TOP/proc" && mount --bind "$TOP/proc/sys" "$TOP/proc/sys" &&
      mount -o remount,bind,ro "$TOP/proc/sys" && mount -t sysfs -o ro sysfs "$TOP/sys" &&
      mount -t cgroup2 cgroup2 "$TOP/sys/fs/cgroup" && cd "$TOP" && mkdir -p .old && pivot_root . .old &&
      umount -l .old && rmdir .old && hostname trial &&
      exec setpriv --bounding-set -sys_time,-sys_module,-sys_rawio,-sys_boot,-syslog \
        env -i container=trial /lib/systemd/systemd --unit=multi-user.target --show-status=no'
  ) &
  container=$!
  disown "$container"
  for _ in $(seq 300); do
    kill -0 "$container" 2>/dev/null || { echo "systemd ended"; return 1; }
    leader=$(pgrep -P "$container" | head -1) || leader=""
    if [ -n "$leader" ] && [ -S "$top/run/systemd/private" ]; then
      case $(inside systemctl is-system-running 2>/dev/null) in running | degraded) return 0 ;; esac
    fi
    sleep 0.2
  done
  inside systemctl list-jobs || true
  echo "systemd is not up after 60 s"
  kill "$container"
  leader=""
  return 1
}
booted=0
if [ "$boot" = 1 ]; then
  echo "== booting"
  if try_boot >"$work/boot.log" 2>&1; then
    booted=1
    rm "$top/usr/sbin/policy-rc.d"
    echo "systemd $(inside systemctl --version | sed -n '1s/systemd \([0-9]*\).*/\1/p') is up"
  else
    leader=""
    tail -5 "$work/boot.log"
    echo "no systemd here: the service is started without it"
  fi
fi

find "$top" -xdev -path "$top/proc" -prune -o -print | sort >"$work/before"
echo "== installing"
if ! inside apt-get install -y --no-install-recommends /opt/sixdial.deb >"$work/install.log" 2>&1; then
  # The lists of packages may be old, or not there.
  inside apt-get update -q >"$work/update.log" 2>&1 || true
  inside apt-get install -y --no-install-recommends /opt/sixdial.deb >"$work/install.log" 2>&1 ||
    { tail -20 "$work/install.log"; die "apt-get could not install it"; }
fi
check "apt-get installed it" says 'ok installed' inside dpkg-query -W -f '${Status}' sixdial
check "the user and the group sixdial are there" inside getent group sixdial
check "the service's user may open serial ports" says dialout inside id -nG sixdial
check "each program tells its version" inside sh -c 'sixdial --version && sixdiald --version && sixdial-mock-rig --version'
for page in man1/sixdial.1 man8/sixdiald.8 man1/sixdial-mock-rig.1; do
  # A root that was made small leaves man pages and documents out (path-exclude of dpkg).
  check "the package has the man page $page" says "$page" inside dpkg -L sixdial
done
check "its files are as they were packed" inside dpkg --verify sixdial
check "an example rig file is understood" inside sixdial rig draw /usr/share/doc/sixdial/examples/rigs/modbus_tcp.toml -o /tmp/rig.svg

inside useradd --create-home --groups sixdial member
inside useradd --create-home stranger

start_directly() {
  mkdir -p "$top/run/sixdial" "$top/var/lib/sixdial"
  inside chown sixdial:sixdial /run/sixdial /var/lib/sixdial
  chmod 755 "$top/run/sixdial"
  chmod 750 "$top/var/lib/sixdial"
  inside setpriv --reuid sixdial --regid sixdial --init-groups env STATE_DIRECTORY=/var/lib/sixdial \
    sixdiald --socket /run/sixdial/sixdiald.sock --clock-speed 20 --clock-start "$1" >"$work/sixdiald.log" 2>&1 &
  service=$!
  for _ in $(seq 100); do
    [ -S "$top/run/sixdial/sixdiald.sock" ] && return 0
    sleep 0.1
  done
  cat "$work/sixdiald.log"
  return 1
}
echo "== starting"
inside ip link set lo up 2>/dev/null || true
mock_start=2026-03-02T08:30:00.000Z
speed=20
if [ "$booted" = 1 ]; then
  speed=1
  check "systemd accepts the units" inside systemd-analyze verify --man=no sixdiald.service sixdiald.socket
  check "the socket unit is enabled and started" inside systemctl enable --now sixdiald.socket
  check "the service waits for its first client" fails inside systemctl is-active sixdiald.service
fi
as member "exec sixdial-mock-rig --speed $speed --start-time $mock_start >mock.json 2>mock.log" &
mock=$!
for _ in $(seq 100); do grep -q ready "$top/home/member/mock.json" 2>/dev/null && break; sleep 0.1; done
if [ "$booted" = 0 ]; then
  start_directly "$mock_start" || die "the service did not start"
fi

echo "== using it"
check "the socket is 0660" socket_mode
check "a member of the group is answered" says sixdiald as member 'sixdial hello'
check "sixdial doctor finds the service and the database well" as member 'sixdial doctor | tee doctor.txt; grep -q "/var/lib/sixdial/sixdial.db: sound" doctor.txt && ! grep -q "^failed" doctor.txt'
check "the mock rig's ports are filled into the rig file" as member '
  robot=$(sed -n "s/.*\"robot_port\":\([0-9]*\).*/\1/p" mock.json); dials=$(sed -n "s/.*\"dial_port\":\([0-9]*\).*/\1/p" mock.json)
  sed -e "s/ROBOT_PORT/$robot/" -e "s/DIAL_PORT/$dials/" /usr/share/doc/sixdial/examples/mock/rig.toml >rig.toml
  ! grep -q _PORT rig.toml'
check "doctor finds the rig's dials and robot" as member 'sixdial doctor --rig rig.toml'
check "a member plans and collects" as member '
  sixdial plan random --rig rig.toml --set G1 --count 12 --seed 1 -o plan.csv &&
  sixdial session create monday --rig rig.toml && sixdial collect plan.csv --session monday'
check "calibrates" as member 'sixdial calibrate monday --seed 1 --quiet'
check "and gets a report" as member 'sixdial report monday -o monday-report && grep -q "</html>" monday-report/*.html'
samples=$(as member 'sixdial --json session show monday' 2>/dev/null | sed -n 's/.*"samples": *\([0-9]*\).*/\1/p' | head -1)
check "all 12 samples are stored" test "${samples:-0}" = 12
check "who did it stands in the record" says member as member 'sixdial session show monday'
check "a stranger is not answered" fails as stranger 'sixdial hello'
check "and is told why" as stranger 'sixdial doctor 2>&1 | tee doctor.txt; grep -q "usermod -aG sixdial" doctor.txt'
check "a stranger cannot read the database" fails as stranger 'cat /var/lib/sixdial/sixdial.db'
check "the database is the service's" says '^sixdial 750' inside stat -c '%U %a' /var/lib/sixdial

if [ "$booted" = 1 ]; then
  check "systemd started the service for its client" says '^active' inside systemctl is-active sixdiald.service
  check "as the user sixdial" says sixdial inside systemctl show -P User sixdiald.service
  inside systemctl kill --signal=KILL sixdiald.service
  check "killed, it answers again, with every sample" says '12 samples' as member 'sleep 1; sixdial session show monday'
  begun=$(date +%s%N)
  check "systemd stops it" inside systemctl stop sixdiald.service
  took_ms=$((($(date +%s%N) - begun) / 1000000))
  check "within 5 s ($took_ms ms)" test "$took_ms" -lt 5000
  check "cleanly" says success inside systemctl show -P Result sixdiald.service
  check "the socket stays, and starts it again" says sixdiald as member 'sixdial hello'
fi

echo "== removing"
kill "$mock" 2>/dev/null || true
if [ "$booted" = 0 ]; then
  begun=$(date +%s%N)
  pkill -TERM -P "$service" 2>/dev/null || kill -TERM "$service"
  wait "$service" 2>/dev/null && ended=0 || ended=$?
  took_ms=$((($(date +%s%N) - begun) / 1000000))
  check "the service ends within 5 s of SIGTERM ($took_ms ms)" test "$took_ms" -lt 5000
  check "with exit code 0 (it was $ended)" test "$ended" = 0
  rm -rf "$top/run/sixdial"
fi
check "apt-get purges it" inside apt-get purge -y sixdial
if [ "$booted" = 1 ]; then
  check "no unit of it runs" fails inside systemctl is-active sixdiald.service sixdiald.socket
fi
check "no program of it is left" fails inside sh -c 'command -v sixdial || command -v sixdiald || command -v sixdial-mock-rig'
check "the database is still there, as promised" test -s "$top/var/lib/sixdial/sixdial.db"
find "$top" -xdev -path "$top/proc" -prune -o -print | sort >"$work/after"
comm -13 "$work/before" "$work/after" | sed "s|^$top||" |
  grep -vE '^/(home/(member|stranger)|var/(mail|spool/mail|log|cache|lib/apt|lib/dpkg)|tmp|run|etc/.*-$|etc/\.pwd\.lock|etc/(subuid|subgid))' >"$work/left" || true
# Packages that came with it belong to apt's autoremove.
inside dpkg-query -S $(cat "$work/left") 2>/dev/null | sed 's/^[^ ]*: //' | sort >"$work/owned" || true
comm -23 <(sort "$work/left") "$work/owned" >"$work/really_left"
echo "left after the purge:"
sed 's/^/      /' "$work/really_left"
check "nothing but the database and its folder is left" fails grep -qv '^/var/lib/sixdial' "$work/really_left"

echo "FIGURE trial.checks $checks"
echo "FIGURE trial.failures $failures"
echo "FIGURE trial.samples ${samples:-0}"
echo "FIGURE trial.left $(wc -l <"$work/really_left")"
echo "FIGURE trial.booted $booted"
[ "$failures" = 0 ] || die "$failures of $checks checks failed"
echo "all $checks checks passed"
