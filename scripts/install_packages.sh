#!/usr/bin/env bash
# Installs the Debian 12 packages pathfit is built with; asks nothing, does nothing when all are there.
# Usage: install_packages.sh build|test
set -euo pipefail

build_packages=(
  g++ cmake ninja-build
  libembree-dev libtbb-dev libceres-dev libopenblas-dev libeigen3-dev
  libopencv-core-dev libopencv-imgproc-dev libopencv-imgcodecs-dev
  libopenexr-dev libimath-dev libopenvdb-dev libopenmesh-dev libboost-dev libboost-iostreams-dev libtinygltf-dev libdraco-dev libmeshoptimizer-dev libstb-dev libexif-dev liblcms2-dev zlib1g-dev libraw-dev
  libyaml-cpp-dev libpugixml-dev libspdlog-dev libfmt-dev libcli11-dev nlohmann-json3-dev libssl-dev libjs-three libcpp-httplib-dev
  libopenmpi-dev openmpi-bin
)
test_packages=(
  libgtest-dev clang-format clang-19 lld-19 libclang-rt-19-dev python3 git dpkg-dev nodejs chromium
  pybind11-dev python3-dev python3-numpy python3-scipy python3-pil
)

packages=("${build_packages[@]}")
if [ "${1:-build}" = test ]; then
  packages+=("${test_packages[@]}")
  # Other packages of Node.js than Debian's bring it along, and refuse Debian's.
  command -v npm >/dev/null || packages+=(npm)
fi

missing=()
for package in "${packages[@]}"; do
  if ! dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q '^install ok installed$'; then
    missing+=("$package")
  fi
done
if [ "${#missing[@]}" -eq 0 ]; then
  echo "packages: all ${#packages[@]} are installed"
  exit 0
fi

sudo=()
if [ "$(id -u)" -ne 0 ]; then
  sudo=(sudo)
fi
echo "packages: installing ${missing[*]}"
export DEBIAN_FRONTEND=noninteractive
"${sudo[@]}" apt-get update -qq
"${sudo[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
