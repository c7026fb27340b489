#!/usr/bin/env bash
# Fails, naming file and line, when a C++ file is not as clang-format would write it.
# With --fix, rewrites the files instead.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

mode=(--dry-run -Werror)
[[ ${1:-} == --fix ]] && mode=(-i)

directories=()
for directory in src cli fuzz tests bench python viewer; do
  [[ -d $directory ]] && directories+=("$directory")
done
find "${directories[@]}" -name node_modules -prune -o \( -name '*.h' -o -name '*.cpp' \) -print0 |
  xargs -0 --no-run-if-empty clang-format "${mode[@]}"
