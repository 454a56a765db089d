# SPDX-License-Identifier: Apache-2.0
# What the libraries are linked to. The build uses this file, and so does the installed package of static libraries;
# shared ones bring all of this themselves.
include("${CMAKE_CURRENT_LIST_DIR}/JuliaVDBPublicDependencies.cmake")
find_dependency(Threads)
find_dependency(TBB)
find_dependency(OpenMesh)
find_dependency(OpenImageIO)
find_dependency(OpenSSL)
find_dependency(ZLIB)
find_dependency(PNG)
find_dependency(PkgConfig)
pkg_check_modules(Cairo REQUIRED cairo-svg cairo-ft freetype2)
# For 3MF; without it that format is refused.
pkg_check_modules(LibZip QUIET libzip)
find_dependency(nlohmann_json)
find_dependency(meshoptimizer)
find_dependency(muparser)

# Debian's OpenImageIO names include folders of packages that it does not depend on. CMake rejects folders that do not
# exist, so they are dropped here.
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
