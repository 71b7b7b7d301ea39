#!/usr/bin/env bash
# schema_3.db: a store as the program of schema 3 left it after use: an imported session with a calibration, one of
# an instrument's positions, one collected on a mock rig with a retaken and an undone sample. Beside it the
# bundles that this very program exports, and the hashes it knew. Usage: make.sh BIN SESSIONS OUTPUT
set -euo pipefail
bin=$1 sessions=$2 out=$(mkdir -p "$3" && cd "$3" && pwd)
work=$(mktemp -d); trap 'kill $service $rig 2>/dev/null || true; rm -rf "$work"' EXIT
export SIXDIAL_SOCKET=$work/s.sock
mkdir "$work/part" "$work/tracker"
{ head -1 "$sessions/00/session.csv"; sed -n 2,31p "$sessions/00/session.csv"; grep '^G2' "$sessions/00/session.csv" | head -10; } > "$work/part/session.csv"
cp "$sessions/00/rig.toml" "$work/part/"; cp "$sessions/00/rig.toml" "$work/tracker/"
awk -F, 'NR == 1 { print "set,theta2_rad,theta1_rad,y_mm,x_mm,dial_F_mm,note" } NR > 1 && NR < 8 {
  printf "%s,%s,%s,%s,%s,%s,n%d\r\n", $1, $6, $5, $8, $7, (NR == 4 ? "" : $17), NR }' "$sessions/00/session.csv" > "$work/tracker/session.csv"
"$bin/sixdial-mock-rig" --rig "$sessions/00/rig.toml" --speed 50 --seed 7 > "$work/ports" & rig=$!
"$bin/sixdiald" --socket "$SIXDIAL_SOCKET" --db "$work/used.db" --clock-speed 50 --clock-start 2026-03-02T08:30:00.000Z 2> "$work/log" & service=$!
until [ -S "$SIXDIAL_SOCKET" ] && [ -s "$work/ports" ]; do sleep 0.2; done
dials=$(sed 's/.*"dial_port":\([0-9]*\).*/\1/' "$work/ports") robot=$(sed 's/.*"robot_port":\([0-9]*\).*/\1/' "$work/ports")
python3 - "$sessions/00/rig.toml" "$work/rig.toml" "$robot" "$dials" <<'PY'
import re, sys
text = open(sys.argv[1]).read()
text = re.sub(r'(?m)^connection = .*\n', '', text)
text = text.replace('[robot]\n', f'[robot]\nconnection = "modbus-tcp://127.0.0.1:{sys.argv[3]}"\n', 1)
text = text.replace('[dials]\n', f'[dials]\nconnection = "modbus-tcp://127.0.0.1:{sys.argv[4]}?unit=1"\n', 1)
open(sys.argv[2], 'w').write(text)
PY
sixdial() { "$bin/sixdial" -q "$@"; }
sixdial session import "$work/part" --name part
sixdial session import "$work/tracker" --name tracker
sixdial calibrate part > /dev/null
sixdial session create collected --rig "$work/rig.toml"
sixdial plan random --rig "$work/rig.toml" --count 6 --seed 3 --approach alternate -o "$work/plan.csv"
sixdial collect "$work/plan.csv" --session collected > /dev/null
sixdial session undo collected
for name in part tracker collected; do sixdial session export "$name" "$out/$name"; done
sixdial shutdown; wait $service || true
sqlite3 "$work/used.db" "PRAGMA wal_checkpoint(TRUNCATE); VACUUM" > /dev/null
cp "$work/used.db" "$out/schema_3.db"
cat "$work/log" >&2
