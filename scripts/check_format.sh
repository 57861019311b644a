#!/usr/bin/env bash
# Fails if a source file is not formatted as .clang-format says (clang-format 14, Debian 12's). --fix rewrites them.
set -euo pipefail
cd "$(dirname "$0")/.."
mapfile -t files < <(find app optim renderer tests -name '*.h' -o -name '*.cpp' | sort)
if [ "${1:-}" = --fix ]; then
  clang-format -i "${files[@]}"
else
  clang-format --dry-run --Werror "${files[@]}"
fi
