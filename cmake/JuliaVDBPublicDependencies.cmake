# SPDX-License-Identifier: Apache-2.0
# What the headers of the libraries need. The build uses this file, and so does the installed package.
include("${CMAKE_CURRENT_LIST_DIR}/JuliaVDBDependency.cmake")

# OpenVDB has its own find module, in a folder that CMake does not search by default.
foreach(prefix IN LISTS OpenVDB_ROOT CMAKE_PREFIX_PATH)
  list(APPEND CMAKE_MODULE_PATH "${prefix}/${CMAKE_INSTALL_LIBDIR}/cmake/OpenVDB" "${prefix}/lib/cmake/OpenVDB")
endforeach()
list(APPEND CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB" "/usr/lib/cmake/OpenVDB")
# CMake no longer has a module for Boost, and says so each time that OpenVDB's find module asks for one.
set(CMAKE_POLICY_DEFAULT_CMP0167 NEW)
# Without this, its find module warns about deprecated options each time CMake runs.
set(OPENVDB_ENABLE_DEPRECATED_WARNINGS OFF)
juliavdb_dependency(OpenVDB 10.0 libopenvdb-dev)
