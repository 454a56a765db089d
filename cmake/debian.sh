# SPDX-License-Identifier: Apache-2.0
# For quickstart and run-tests: the packages that Debian 12 needs, and how to build. To be sourced in the project's root.

# fonts-dejavu-core has the font of the text in plots, which becomes a part of the library. openimageio-tools is needed
# because OpenImageIO's CMake files insist on its programs being installed.
BUILD_PACKAGES=(g++ cmake ninja-build libopenvdb-dev libtbb-dev libeigen3-dev liblbfgspp-dev libmuparser-dev
  libopenmesh-dev libopenimageio-dev openimageio-tools libcairo2-dev libfreetype-dev fonts-dejavu-core pkg-config libssl-dev
  nlohmann-json3-dev libmeshoptimizer-dev libboost-dev libboost-iostreams-dev libboost-program-options-dev libblosc-dev
  zlib1g-dev libpng-dev libzip-dev opencl-c-headers libnanovdb-dev)
QUICKSTART_PACKAGES=(glmark2-data)
# slurm-wlm and parallel run the tests of farms: a true cluster, of one node. python3-dev and pybind11-dev build the Python
# module, and python3-numpy runs it. blender runs the tests of the add-on; with what it needs, it is a download of 90 MB.
# pocl-opencl-icd makes the processor a device of OpenCL, with which the devices are tested; oclgrind is one that watches.
# libnanovdb-tools reads our NanoVDB files, python3-tifffile the layers of stacks, and python3-meshio our meshes.
# chromium and its driver, which Selenium speaks to, show the page of 'juliavdb explore'; 90 MB.
TEST_PACKAGES=(dpkg-dev file groff-base libgtest-dev libbenchmark-dev libopenvdb-tools python3 python3-openvdb python3-dev
  pybind11-dev python3-numpy python3-pip python3-setuptools python3-wheel libtinygltf-dev clang-format doxygen git
  ca-certificates slurm-wlm munge parallel blender chromium chromium-driver python3-selenium pocl-opencl-icd oclgrind
  libnanovdb-tools python3-tifffile python3-meshio)

as_root() {
  local sudo=()
  [ "$(id -u)" -eq 0 ] || sudo=(sudo)
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive "$@"
}

# Installs those of the given packages that are missing.
install_packages() {
  local missing=() package
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'install ok installed' || missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return
  echo "== installing ${missing[*]}"
  as_root apt-get update -qq
  as_root apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

# Builds build/release with the given CMake options.
build_release() {
  echo "== building"
  mkdir -p build
  cmake --preset release -DCMAKE_UNITY_BUILD=ON "$@" >build/configure.log 2>&1 || { cat build/configure.log >&2; return 1; }
  cmake --build --preset release
}
