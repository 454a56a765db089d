# SPDX-License-Identifier: Apache-2.0
# What the libraries need; used by the build and, installed, by those who link to them.
include(CMakeFindDependencyMacro)

# OpenVDB comes with a find module of its own, in a folder that CMake does not search by itself.
list(APPEND CMAKE_MODULE_PATH "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/cmake/OpenVDB" "/usr/lib/cmake/OpenVDB")
# Its headers mention options that it warns about being deprecated at every configure.
set(OPENVDB_ENABLE_DEPRECATED_WARNINGS OFF)
find_dependency(Threads)
find_dependency(TBB)
find_dependency(OpenVDB)
find_dependency(OpenMesh)
find_dependency(OpenImageIO)
find_dependency(OpenSSL)
find_dependency(PkgConfig)
pkg_check_modules(Cairo REQUIRED cairo-svg)
find_dependency(nlohmann_json)
find_dependency(muparser)
find_dependency(Boost COMPONENTS program_options)

# Debian's OpenImageIO names include folders of packages that it does not depend on, which CMake refuses.
foreach(target OpenImageIO::OpenImageIO OpenImageIO::OpenImageIO_Util)
  if(TARGET ${target})
    get_target_property(directories ${target} INTERFACE_INCLUDE_DIRECTORIES)
    set(there "")
    foreach(directory IN LISTS directories)
      if(EXISTS "${directory}")
        list(APPEND there "${directory}")
      endif()
    endforeach()
    set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${there}")
  endif()
endforeach()
