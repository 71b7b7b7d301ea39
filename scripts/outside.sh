#!/usr/bin/env bash
# Measured data that nobody here made, held-out: prints a table beside what is asked, and exits 1
# where a figure is missed.
#   scripts/outside.sh DIR [--bin FOLDER] [--seeds 10]     two minutes of one core
# DIR: ur10_leica/, delta_probe/, positioner/, sockets/ as their publishers have them. Nothing of it
# is copied; the maps of examples/import/ read it.
set -euo pipefail
here=$(cd "$(dirname "$(readlink -f "$0")")/.." && pwd)
bin=$here/build/release/bin seeds=10 dir=''
while [ $# -gt 0 ]; do
  case $1 in
    --bin) bin=$2; shift 2 ;;
    --seeds) seeds=$2; shift 2 ;;
    -*) sed -n '2,6s/^# //p' "$0"; exit 2 ;;
    *) dir=$1; shift ;;
  esac
done
[ -n "$dir" ] || { sed -n '2,6s/^# //p' "$0"; exit 2; }
program=$bin/held_out
[ -x "$program" ] || { echo "outside: $program is missing: cmake --build build/release --target held_out" >&2; exit 2; }
maps=$here/examples/import
notes=$(mktemp)
trap 'rm -f "$notes"' EXIT
missed=0

run() { "$program" "$@" 2>>"$notes"; }
# figure of a JSON line: fitted.mean_mm
figure() { python3 -c 'import functools, json, sys
print(functools.reduce(lambda d, k: d[k], sys.argv[1].split("."), json.load(sys.stdin)))' "$1"; }
row() {  # what, figure, asked
  local verdict=ok
  python3 -c 'import sys; sys.exit(not float(sys.argv[1]) <= float(sys.argv[2]))' "$2" "$3" ||
    { verdict=MISSED; missed=1; }
  printf '| %s | %.4f | %s | %s |\n' "$1" "$2" "$3" "$verdict"
}
told() { printf '| %s | %.4f | | |\n' "$1" "$2"; }
absent() { printf '| %s | no files | | MISSED |\n' "$1"; missed=1; }

printf '| set, mm | ours | asked | |\n|---|---|---|---|\n'

ur10=("$dir"/ur10_leica/*.csv)
if [ -e "${ur10[0]}" ]; then
  plain=$(run "${ur10[@]}" --map "$maps/ur10_leica_map.toml" --scheme groups --seeds "$seeds")
  told 'UR10, registered' "$(figure nominal.mean_mm <<<"$plain")"
  row 'UR10, geometry, halves of the poses' "$(figure fitted.mean_mm <<<"$plain")" 0.40
  curved=$(run "${ur10[@]}" --map "$maps/ur10_leica_map.toml" --scheme groups --seeds "$seeds" --curves 60)
  row 'UR10, and a curve of each joint' "$(figure fitted.mean_mm <<<"$curved")" 0.115
  alternate=$(run "${ur10[@]}" --map "$maps/ur10_leica_map.toml" --scheme alternate --curves 60)
  told 'UR10, the same, alternate rows' "$(figure fitted.mean_mm <<<"$alternate")"
else
  absent UR10
fi

delta=("$dir"/delta_probe/*.csv)
if [ -e "${delta[0]}" ]; then
  six=radius,angle_b,angle_c,stop_a,stop_b,stop_c
  ends=$(run "${delta[@]}" --map "$maps/delta_probe_map.toml" --scheme fit --free stop_a,stop_b,stop_c)
  told 'delta, end stops alone, z rms' "$(figure fitted.rms_mm <<<"$ends")"
  fit=$(run "${delta[@]}" --map "$maps/delta_probe_map.toml" --scheme fit --free $six)
  row 'delta, six parameters, z rms' "$(figure fitted.rms_mm <<<"$fit")" 0.040
  one=$(run "${delta[@]}" --map "$maps/delta_probe_map.toml" --scheme one --free $six)
  row 'delta, one point left out in turn' "$(figure fitted.rms_mm <<<"$one")" 0.055
else
  absent delta
fi

positioner=("$dir"/positioner/*.yaml)
if [ -e "${positioner[0]}" ]; then
  halves=$(run "${positioner[@]}" --map "$maps/robot_cal_tools_map.toml" --scheme alternate)
  told 'positioner, registered' "$(figure nominal.mean_mm <<<"$halves")"
  row 'positioner, alternate rows' "$(figure fitted.mean_mm <<<"$halves")" 0.40
else
  absent positioner
fi

sockets=()
while IFS= read -r file; do sockets+=("$file"); done < <(
  find -L "$dir/sockets" -name 'hole_[0-9].csv' 2>/dev/null | sort)
if [ ${#sockets[@]} -gt 0 ]; then
  places=$(run "${sockets[@]}" --map "$maps/sockets_map.toml" --scheme places)
  told 'sockets, nominal' "$(figure nominal.mean_mm <<<"$places")"
  row 'sockets, each place left out in turn' "$(figure fitted.mean_mm <<<"$places")" 0.38
  told "sockets, worst place ($(figure worst_place <<<"$places"))" "$(figure worst_place_mm <<<"$places")"
else
  absent sockets
fi

printf '\nWhat was said on the way:\n'
sort "$notes" | uniq -c | sort -rn | head -40
exit $missed
