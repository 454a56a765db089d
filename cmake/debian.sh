# SPDX-License-Identifier: Apache-2.0
# For quickstart, run-tests and .ci: the packages that Debian 12 and 13 need, and how to build. To be sourced in the project's
# root. Functions that fail have said why in one line.

# A question mark behind a name: a release that has no such package goes without it.
#
# fonts-dejavu-core has the font of the text in plots, which becomes a part of the library. openimageio-tools is needed
# because OpenImageIO's CMake files insist on its programs being installed. python3-dev and pybind11-dev build the Python
# module, and python3-numpy runs it.
BUILD_PACKAGES=(g++ cmake ninja-build libopenvdb-dev libtbb-dev libeigen3-dev liblbfgspp-dev libmuparser-dev
  libopenmesh-dev libopenimageio-dev openimageio-tools libcairo2-dev libfreetype-dev fonts-dejavu-core pkg-config libssl-dev
  nlohmann-json3-dev libmeshoptimizer-dev libboost-dev libboost-iostreams-dev libboost-program-options-dev libblosc-dev
  zlib1g-dev libpng-dev libzip-dev libexpat1-dev libdraco-dev libassimp-dev opencl-c-headers libnanovdb-dev python3
  python3-dev python3-numpy pybind11-dev)
QUICKSTART_PACKAGES=(glmark2-data)
# slurm-wlm and parallel run the tests of farms: a true cluster, of one node. blender runs the tests of the add-on; with
# what it needs, it is a download of 90 MB.
# pocl-opencl-icd makes the processor a device of OpenCL, with which the devices are tested; oclgrind is one that watches,
# and Debian 13 has none. clang-format lays out C++ another way in each version, and 14 is the one that counts here.
# patchelf, xz-utils and ocl-icd-libopencl1 make a bundle. libnanovdb-tools reads our NanoVDB files, python3-tifffile the
# layers of stacks, and python3-meshio our meshes.
# chromium and its driver, which Selenium speaks to, show the page of 'juliavdb explore'; 90 MB.
TEST_PACKAGES=(dpkg-dev file groff-base libgtest-dev libbenchmark-dev libopenvdb-tools python3-openvdb
  python3-pip python3-setuptools python3-wheel libtinygltf-dev 'clang-format-14?' doxygen git
  ca-certificates slurm-wlm munge parallel blender chromium chromium-driver python3-selenium pocl-opencl-icd 'oclgrind?'
  libnanovdb-tools python3-tifffile python3-meshio patchelf xz-utils ocl-icd-libopencl1)

complain() { echo "${0##*/}: $*" >&2; }

as_root() {
  local sudo=()
  [ "$(id -u)" -eq 0 ] || sudo=(sudo)
  "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive LC_ALL=C "$@"
}

# The last line of some words that matches a pattern.
last_line() { grep -E "$2" <<<"$1" | tail -n 1 | sed 's/^ *//' | grep .; }

# Says in one line why apt-get failed, from all that it said, and what to do. @return the exit code for it
explain_apt() {
  local words=$1 line
  shift
  if line=$(last_line "$words" '^sudo: '); then
    complain "only root can install packages, and sudo refused ($line); as root: apt-get install $*"
    return 77
  elif line=$(last_line "$words" 'Could not get lock|Unable to (acquire|lock)|is another process using it'); then
    complain "another program is installing packages ($line); wait for its end, and start this again"
    return 75
  elif line=$(last_line "$words" "No space left on device|don't have enough free space|Disk quota exceeded"); then
    complain "the disk is full ($line); make room, for example by 'apt-get clean', and start this again"
    return 74
  elif line=$(last_line "$words" 'Temporary failure|Could not (resolve|connect)|Failed to fetch|Network is unreachable'); then
    complain "the packages cannot be fetched ($line); see to the network, or set http_proxy if a proxy is needed"
    return 69
  elif line=$(last_line "$words" 'Unable to locate package|has no installation candidate'); then
    complain "this release has no such package ($line); docs/platforms.md lists the systems that have all of them"
    return 69
  fi
  line=$(last_line "$words" '^(E|dpkg|W): ') || line=$(tail -n 1 <<<"$words")
  complain "apt-get could not install $* ($line)"
  return 69
}

# Whether this user may install packages at all.
can_install() {
  [ "$(id -u)" -ne 0 ] && ! command -v sudo >/dev/null || return 0
  complain "only root can install packages, and sudo is not here; as root: apt-get install $*"
  return 77
}

# Installs packages by apt-get, and waits a minute for another program to release its lock.
apt_install() {
  can_install "$@" || return
  local said
  said=$(as_root apt-get -o DPkg::Lock::Timeout=60 install -y -qq --no-install-recommends "$@" 2>&1) && return
  explain_apt "${UPDATE_SAID-}"$'\n'"$said" "$@"
}

# Whether apt knows a package that it could install.
apt_knows() { LC_ALL=C apt-cache policy "$1" 2>/dev/null | grep -q '^  Candidate: [^(]'; }

# Installs those of the given packages that are missing, and asks apt for nothing if none is.
install_packages() {
  if ! command -v dpkg-query >/dev/null; then
    source cmake/other-systems.sh
    name_other_packages
    return
  fi
  local missing=() optional=() package
  for package in "$@"; do
    dpkg-query -W -f='${Status}' "${package%\?}" 2>/dev/null | grep -q 'install ok installed' && continue
    case $package in
      *\?) optional+=("${package%\?}") ;;
      *) missing+=("$package") ;;
    esac
  done
  if [ ${#missing[@]} -gt 0 ]; then
    if ! command -v apt-get >/dev/null; then
      complain "these packages are missing, and there is no apt-get to install them: ${missing[*]}"
      return 69
    fi
    can_install "${missing[@]}" || return
    echo "== installing ${missing[*]}"
    # What it could not fetch counts only if a package is missing then.
    UPDATE_SAID=$(as_root apt-get update -qq 2>&1) || true
    apt_install "${missing[@]}" || return
  fi
  local left_out=() known=()
  for package in "${optional[@]}"; do
    if apt_knows "$package"; then known+=("$package"); else left_out+=("$package"); fi
  done
  if [ ${#known[@]} -gt 0 ]; then
    echo "== installing ${known[*]}"
    apt_install "${known[@]}" || left_out+=("${known[@]}")
  fi
  [ ${#left_out[@]} -eq 0 ] || echo "== going on without what this release lacks or what could not be installed: ${left_out[*]}"
}

# Whether a program is of a version or later; the version is the first number with a point that it prints.
is_at_least() {
  local found
  found=$("$1" --version | grep -oE '[0-9]+\.[0-9.]+' | head -n 1)
  [ "$(printf '%s\n' "$2" "$found" | sort -V | head -n 1)" = "$2" ] && return
  complain "$1 $found is too old, as $2 or later is needed; $3 has a newer one"
  return 1
}

check_tools() {
  local oldest
  oldest=$(sed -n 's/^cmake_minimum_required(VERSION \([0-9.]*\)).*/\1/p' CMakeLists.txt)
  if ! command -v cmake >/dev/null; then
    complain "cmake is not here, and $oldest or later is needed; the system's package cmake or https://cmake.org/download has it"
    return 69
  elif ! command -v ninja >/dev/null; then
    complain "ninja is not here; the system's package ninja-build or ninja has it, or https://ninja-build.org"
    return 69
  fi
  is_at_least cmake "$oldest" https://cmake.org/download || return 69
}

# Says so if the disk of one of the folders is full.
is_disk_full() {
  local folder free
  for folder in "$@"; do
    free=$(df -Pk "$folder" | awk 'NR == 2 { print $4 }')
    if [ "${free:-0}" -lt 10000 ]; then
      complain "the disk of '$folder' is full, as only $free kB are free; make room, and start this again"
      return 0
    fi
  done
  return 1
}

# The first error of CMake's output, in one line.
configure_error() {
  awk '/^CMake Error: / && !on { sub(/^CMake Error: /, ""); print; exit }
       /^CMake Error/ && !on { on = 1; next }
       on && /^  / { sub(/^ +/, ""); text = text (text == "" ? "" : " ") $0; next }
       on && /^./ { exit }
       END { if (text != "") print text }' "$1"
}

# Builds build/release with the given CMake options.
build_release() {
  check_tools || return
  echo "== building"
  mkdir -p build || return 73
  if ! cmake --preset release -DCMAKE_UNITY_BUILD=ON "$@" >build/configure.log 2>&1; then
    is_disk_full build "${TMPDIR:-/tmp}" && return 74
    local error
    error=$(configure_error build/configure.log)
    [ -n "$error" ] || { cat build/configure.log >&2; return 69; }
    complain "$error (build/configure.log has the rest)"
    return 69
  fi
  sed -n 's/^-- \(Left out: .*\)/\1/p' build/configure.log
  cmake --build --preset release && return
  is_disk_full build "${TMPDIR:-/tmp}" && return 74
  return 1
}
