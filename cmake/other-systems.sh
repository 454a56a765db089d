# SPDX-License-Identifier: Apache-2.0
# What the packages of cmake/debian.sh are called where there is no dpkg. To be sourced by it. These names were looked up and
# not tried (docs/platforms.md); environment.yml has conda-forge's.
FEDORA_PACKAGES=(gcc-c++ cmake ninja-build openvdb-devel tbb-devel eigen3-devel muParser-devel OpenMesh-devel OpenImageIO-devel
  OpenImageIO-utils cairo-devel freetype-devel dejavu-sans-fonts pkgconf-pkg-config openssl-devel json-devel
  meshoptimizer-devel boost-devel blosc-devel zlib-devel libpng-devel libzip-devel expat-devel draco-devel assimp-devel
  opencl-headers python3-devel pybind11-devel glmark2)
ARCH_PACKAGES=(base-devel cmake ninja openvdb onetbb eigen muparser openimageio cairo freetype2 ttf-dejavu pkgconf openssl
  nlohmann-json boost blosc zlib libpng libzip expat draco assimp opencl-headers python pybind11 glmark2)
# What these two do not have as a package, or have in the AUR alone.
FEDORA_MISSING=(LBFGSpp)
ARCH_MISSING=(LBFGSpp OpenMesh meshoptimizer)

# Prints what this system calls the packages. What is missing of them, configuring says.
name_other_packages() {
  local like=''
  [ ! -r /etc/os-release ] || like=$(. /etc/os-release && echo " ${ID-} ${ID_LIKE-} ")
  echo "== this system has no dpkg; these packages are needed, and nothing is installed:"
  if [ -n "${CONDA_PREFIX-}" ]; then
    echo "conda-forge: conda env update --file environment.yml"
    return
  fi
  case $like in
    *' fedora '*) echo "Fedora: dnf install ${FEDORA_PACKAGES[*]}; by hand: ${FEDORA_MISSING[*]}" ;;
    *' arch '*) echo "Arch: pacman -S --needed ${ARCH_PACKAGES[*]}; by hand or from the AUR: ${ARCH_MISSING[*]}" ;;
    *)
      echo "Fedora: ${FEDORA_PACKAGES[*]}; by hand: ${FEDORA_MISSING[*]}"
      echo "Arch: ${ARCH_PACKAGES[*]}; by hand or from the AUR: ${ARCH_MISSING[*]}"
      echo "conda-forge, on any system: conda env create --file environment.yml" ;;
  esac
}
