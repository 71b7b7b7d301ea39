#!/usr/bin/env bash
# Makes doc/pictures/ from a real run of the demo. Needs chromium. Usage: scripts/pictures.sh [out/demo]
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."
demo=$(readlink -f "${1:-out/demo}")
[ -f "$demo/report/report.html" ] || { echo "pictures: no $demo/report/report.html; ./run demo makes it" >&2; exit 1; }
mkdir -p doc/pictures
profile=$(mktemp -d)
trap 'rm -rf "$profile"' EXIT
chromium --headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking \
  --disable-component-update --disable-sync --hide-scrollbars --user-data-dir="$profile" \
  --window-size=1000,1900 --screenshot=doc/pictures/report.png "file://$demo/report/report.html" 2>/dev/null
ls -l doc/pictures
