# What the demos share; sourced after `bin` (folder of the programs) and `out` (folder of results) are set.
speed=${SIXDIAL_DEMO_SPEED:-20}
begun=$SECONDS

say() { printf '\n-- %s  [%d s]\n' "$*" $((SECONDS - begun)); }
die() { printf 'demo: %s\n' "$*" >&2; exit 1; }

rm -rf "$out"
mkdir -p "$out"
out=$(readlink -f "$out")
# A Unix socket's path is short; the output folder's may not be.
run_dir=$(mktemp -d "${TMPDIR:-/tmp}/sixdial-demo.XXXXXX")
socket=$run_dir/sixdiald.sock
mock_pid='' daemon_pid=''
finish() {
  [ -z "$daemon_pid" ] || kill -TERM "$daemon_pid" 2>/dev/null || true
  [ -z "$mock_pid" ] || kill -TERM "$mock_pid" 2>/dev/null || true
  wait 2>/dev/null || true
  rm -rf "$run_dir"
}
trap finish EXIT
wait_for() {  # what, command ...: up to a minute
  local what=$1 i
  shift
  for ((i = 0; i < 600; i++)); do
    "$@" && return 0
    sleep 0.1
  done
  die "$what did not come up; see $out/*.log"
}
sixdial() { "$bin/sixdial" --socket "$socket" "$@"; }
port() { sed -n "s/.*\"$1_port\":\([0-9]*\).*/\1/p" "$out/mock-rig.json"; }

start=$(date -u +%Y-%m-%dT%H:%M:%S.000Z)
# Arguments: of the mock rig, beside speed and start.
start_mock() {
  "$bin/sixdial-mock-rig" --speed "$speed" --start-time "$start" "$@" \
    >"$out/mock-rig.json" 2>"$out/mock-rig.log" &
  mock_pid=$!
  wait_for "the mock rig" grep -qs '"ready":true' "$out/mock-rig.json"
}
start_service() {
  say "Service on a Unix socket, with its SQLite store"
  "$bin/sixdiald" --socket "$socket" --db "$out/sixdial.db" --clock-speed "$speed" \
    --clock-start "$start" 2>"$out/sixdiald.log" &
  daemon_pid=$!
  wait_for "the service" test -S "$socket"
  sixdial hello
}
# Points of G1 and of G2.
plan_points() {
  say "Plan: $1 points G1 to calibrate, $2 points G2 to validate"
  sixdial plan random --rig "$out/rig.toml" --set G1 --count "$1" --seed 1 -o "$out/g1.csv"
  sixdial plan random --rig "$out/rig.toml" --set G2 --count "$2" --seed 2 -o "$out/g2.csv"
  { cat "$out/g1.csv"; tail -n +2 "$out/g2.csv"; } >"$out/plan.csv"
}
collect_plan() {  # what is read at each point
  say "Collecting: move, settle, read $1, check, store"
  sixdial session create demo --rig "$out/rig.toml"
  local collecting=$SECONDS
  sixdial collect "$out/plan.csv" --session demo
  printf '   collected in %d s\n' $((SECONDS - collecting))
}
name_causes() {
  say "Diagnosis: what the simulation gets wrong, and why"
  sixdial --quiet diagnose demo --report "$out/diagnosis.html" -o "$out/diagnosis.json" >"$out/diagnosis.txt" 2>/dev/null
  awk 'NF == 0 { exit } { print "   " $0 }' "$out/diagnosis.txt"
}
list_results() {
  say "Diagnosis: $(head -1 "$out/diagnosis.txt")"
  say "Done. Look at:"
  find "$out" -type f ! -name '*.log' ! -name 'sixdial.db-*' | sort | sed "s|^$PWD/|   |"
}
