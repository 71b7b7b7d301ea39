#!/usr/bin/env bash
# Format and static checks over the tracked sources. Needs build/release/compile_commands.json for
# clang-tidy and cppcheck; configures it if it is absent.
set -euo pipefail
cd "$(dirname "$(readlink -f "$0")")/.."

mapfile -t sources < <(git ls-files '*.cpp' '*.h')
echo "== clang-format: ${#sources[@]} files"
clang-format --dry-run --Werror "${sources[@]}"

echo "== words that say unfinished"
if git grep -nIwE 'TODO|FIXME|XXX|HACK' -- ':!scripts/check.sh' ':!CONTRIBUTING.md'; then
  echo "check: finish these or say in doc/ what is left" >&2
  exit 1
fi

[ -f build/release/compile_commands.json ] || cmake --preset release >/dev/null
echo "== cppcheck"
cppcheck --project=build/release/compile_commands.json --quiet --enable=warning,portability \
  --inline-suppr --suppressions-list=.cppcheck-suppressions -j "$(nproc)" --error-exitcode=1

# clang-tidy takes ten seconds a file with Eigen in it: by default the folders that everything
# stands on; `scripts/check.sh all` reads every folder.
folders=(geometry simulation session)
[ "${1:-}" = all ] && folders+=(calibration acquisition mock_devices diagnosis db report service apps)
echo "== clang-tidy: ${folders[*]}"
git ls-files "${folders[@]/%//*.cpp}" | xargs -P "$(nproc)" -n 4 clang-tidy -p build/release --quiet 2>/dev/null
echo "checks passed"
