# SPDX-License-Identifier: Apache-2.0
# The target `package` makes a Debian package of the program and its libraries, without the headers:
# juliavdb_VERSION_ARCHITECTURE.deb in the build folder. It installs on Debian 12; what it depends on is found out by
# dpkg-shlibdeps.
set(JULIAVDB_MAINTAINER "JuliaVDB maintainers <maintainers@juliavdb.invalid>" CACHE STRING
    "Who is named as the maintainer of packages")

install(FILES cmake/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/juliavdb COMPONENT Runtime)
install(FILES CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/juliavdb COMPONENT Runtime)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME juliavdb)
set(CPACK_PACKAGE_VENDOR JuliaVDB)
set(CPACK_PACKAGE_CONTACT "${JULIAVDB_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "fractals in the shape of a mesh, as OpenVDB level sets")
set(CPACK_PACKAGE_DESCRIPTION
"JuliaVDB turns a mesh into a fractal of the same shape: a level set for
Houdini or Blender, a mesh, or pictures. The program runs without a display,
and cuts large jobs into tasks for Slurm or GNU parallel.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)

set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBDebian.cmake)

# One component alone goes into the package.
set(CPACK_COMPONENTS_ALL Runtime)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME juliavdb)
set(CPACK_DEBIAN_RUNTIME_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_MAINTAINER "${JULIAVDB_MAINTAINER}")
# The libraries of the project itself are in the package, in a folder of their own.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/libjulia ${PROJECT_BINARY_DIR}/vdbtools)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS OFF)
if(TARGET juliavdb_python)
  # The module is for one version of Python; without it the program works all the same.
  set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "${JULIAVDB_PYTHON_RECOMMENDS}")
endif()
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SUGGESTS "ocl-icd-libopencl1, parallel, slurm-client")
set(CPACK_DEBIAN_RUNTIME_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION}")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "${CPACK_PACKAGE_DESCRIPTION}")
include(CPack)
