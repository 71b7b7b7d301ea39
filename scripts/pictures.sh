#!/usr/bin/env bash
# Makes doc/pictures/ from a real run on the mock rig: the live page and the terminal in the middle of a
# session, the report's first page. Needs chromium, python3, tmux. Usage: scripts/pictures.sh [BIN_FOLDER]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
bin=$(readlink -f "${1:-build/release/bin}")
pictures=$PWD/doc/pictures
speed=1
for program in chromium python3 tmux; do
  command -v "$program" >/dev/null || { echo "pictures: $program is missing: apt-get install $program" >&2; exit 1; }
done
[ -x "$bin/sixdiald" ] || { echo "pictures: no $bin/sixdiald; ./run build makes it" >&2; exit 1; }
mkdir -p "$pictures"
work=$(mktemp -d)
socket=$work/s
mock_pid='' daemon_pid=''
finish() {
  tmux -L "sixdial-$$" kill-server 2>/dev/null || true
  [ -z "$daemon_pid" ] || kill -TERM "$daemon_pid" 2>/dev/null || true
  [ -z "$mock_pid" ] || kill -TERM "$mock_pid" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
wait_for() {  # what, command ...: up to a minute
  local what=$1 i
  shift
  for ((i = 0; i < 600; i++)); do
    "$@" && return 0
    sleep 0.1
  done
  echo "pictures: $what did not come" >&2
  exit 1
}
start=$(date -u +%Y-%m-%dT%H:%M:%S.000Z)
"$bin/sixdial-mock-rig" --speed $speed --start-time "$start" --robot table2 --seed 2021 --warp 0.02 \
  --hide joint_backlash:joint2:0.0006 >"$work/mock.json" &
mock_pid=$!
wait_for "the mock rig" grep -q '"ready":true' "$work/mock.json"
port() { sed -n "s/.*\"$1_port\":\([0-9]*\).*/\1/p" "$work/mock.json"; }
sed -e "s/ROBOT_PORT/$(port robot)/" -e "s/DIAL_PORT/$(port dial)/" examples/mock/rig.toml >"$work/rig.toml"
"$bin/sixdiald" --socket "$socket" --db "$work/sixdial.db" --clock-speed $speed --clock-start "$start" \
  --live 0 >"$work/url" 2>"$work/sixdiald.log" &
daemon_pid=$!
wait_for "the service" test -S "$socket"
wait_for "the live page" grep -q http "$work/url"
url=$(sed -n 's/^Live page: //p' "$work/url")
sixdial() { "$bin/sixdial" --socket "$socket" "$@"; }

sixdial plan random --rig "$work/rig.toml" --set G1 --count 60 --seed 1 -o "$work/g1.csv" 2>/dev/null
sixdial plan random --rig "$work/rig.toml" --set G2 --count 30 --seed 2 -o "$work/g2.csv" 2>/dev/null
{ cat "$work/g1.csv"; tail -n +2 "$work/g2.csv"; } >"$work/plan.csv"
sixdial session create monday --rig "$work/rig.toml" >/dev/null

# The terminal shows the same collection that the live page shows.
tmux -L "sixdial-$$" -f /dev/null new-session -d -x 116 -y 36 \
  "env PS1='\$ ' LC_ALL=C.UTF-8 '$bin/sixdial' --socket '$socket' collect '$work/plan.csv' --session monday; sleep 600"
picture() {  # picture.py's arguments
  python3 scripts/picture.py "$@"
}
picture live "$url" "$pictures/live.png" 24
tmux -L "sixdial-$$" capture-pane -p >"$work/terminal.txt"
picture text "$work/terminal.txt" "$pictures/terminal.png"
collected() { sixdial --json collection status | grep -q '"state": *"done"'; }
wait_for "the end of the collection" collected
sixdial --quiet calibrate monday --seed 1 >/dev/null
sixdial --quiet diagnose monday >/dev/null 2>&1
sixdial --quiet report monday -o "$work/report" >/dev/null
picture page "$work/report/report.html" "$pictures/report.png"
ls -l "$pictures"
