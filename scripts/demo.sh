#!/usr/bin/env bash
# Fits the shape and colours of a bronze axe to 24 photographs (data/axe), from its visual hull.
# Installs what is missing, builds the program, runs the fit; prints the run directory and the report.
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/install_packages.sh build
echo "build: build/demo"
cmake -S . -B build/demo -G Ninja -DCMAKE_BUILD_TYPE=Release -DPATHFIT_TESTS=OFF -DPATHFIT_UNITY=ON >/dev/null
cmake --build build/demo

echo "fit: configs/axe_demo.yaml"
run=$(build/demo/app/pathfit fit configs/axe_demo.yaml "$@")
echo "run directory: $run"
echo "report:        $run/report.html"
