#!/usr/bin/env bash
# Installs what is missing, then: formatting, build with warnings as errors, all tests, and the quick tests again under
# the address and undefined-behaviour sanitizers. Ends with a line "N passed, N failed".
set -uo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh test || exit 1

passed=0
failed=0
report=""  # what failed, said once more at the end
fail() {  # fail NAME [COUNT [OUTPUT]]: counts what failed, and says it now and at the end
  echo "FAILED: $1"
  report+="FAILED: $1"$'\n'"${3:+$3$'\n'}"
  failed=$((failed + ${2:-1}))
}
step() {  # step NAME COMMAND...: one check that counts as one test
  local name=$1
  shift
  echo "== $name"
  if "$@"; then
    passed=$((passed + 1))
  else
    fail "$name"
  fi
}
tests() {  # tests PRESET: builds and runs a preset's tests, adds their numbers
  local preset=$1 log status good bad
  echo "== build and tests: $preset"
  if ! LDFLAGS=-fuse-ld=gold cmake --preset "$preset" -DPATHFIT_UNITY=ON >"build/$preset.configure.log" 2>&1 || ! cmake --build --preset "$preset"; then
    tail -n 20 "build/$preset.configure.log"
    fail "build $preset"
    return
  fi
  log="build/$preset.ctest.log"
  ctest --preset "$preset" -j 2 | tee "$log"
  status=${PIPESTATUS[0]}
  if ! grep -qE '^[0-9]+% tests passed' "$log"; then
    fail "tests $preset"
    return
  fi
  read -r good bad <<<"$(numbers_of "build/$preset/Testing/Temporary/LastTest.log")"
  [ "$status" -eq 0 ] || [ "$bad" -gt 0 ] || bad=1  # one that did not even run
  passed=$((passed + good))
  [ "$bad" -eq 0 ] || fail "tests $preset" "$bad" "$(failures_of "$log")"
}
numbers_of() {  # numbers_of LOG: how many tests passed and failed; programs of many tests (GoogleTest) say their numbers
  awk '/^\[  PASSED  \] [0-9]+ tests?\.$/ { good += $4; counted = 1 }
       /^\[  FAILED  \] .* \([0-9]+ ms\)$/ { ++bad_here }
       /^Test Passed\.$/ { if (!counted) ++good; counted = bad_here = 0 }
       /^Test Failed\.$/ { bad += bad_here ? bad_here : 1; counted = bad_here = 0 }
       END { print good + 0, bad + 0 }' "$1"
}
failures_of() {  # failures_of LOG: each failed test's line in ctest's log with the last of what it printed
  awk '/^ *[0-9]+\/[0-9]+ Test +#[0-9]+: / { flush(); if (!/ Passed +[0-9]|\*\*\*Skipped/) { title = $0; n = 0 } next }
       /^ +Start +[0-9]+: / || /^[0-9]+% tests passed/ { flush(); next }
       title != "" { lines[n++] = $0 }
       function flush(   i) {
         if (title == "") return
         print title
         for (i = n > 40 ? n - 40 : 0; i < n; ++i) print "    " lines[i]
         title = ""
       }' "$1"
}

mkdir -p build/npm
# The one thing that is no Debian package: the Khronos Group's validator of GLB files, for e2e/gltf.
cp tests/e2e/package.json tests/e2e/package-lock.json build/npm/
if npm ci --prefix build/npm --no-audit --no-fund --loglevel=error; then
  export NODE_PATH="$PWD/build/npm/node_modules${NODE_PATH:+:$NODE_PATH}"
else
  echo "WARNING: npm cannot install gltf-validator: e2e/gltf is SKIPPED, and GLB files are not validated"
fi
step "formatting" scripts/check_format.sh
tests release
tests asan

[ -z "$report" ] || echo "$report"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ]
