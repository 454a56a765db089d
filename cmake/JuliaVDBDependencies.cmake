# SPDX-License-Identifier: Apache-2.0
# What the libraries are linked to. The build uses this file, and so does the installed package of static libraries;
# shared ones bring all of this themselves.
include("${CMAKE_CURRENT_LIST_DIR}/JuliaVDBPublicDependencies.cmake")
find_dependency(Threads)
juliavdb_dependency(TBB 2021 libtbb-dev)
juliavdb_dependency(OpenMesh "" libopenmesh-dev)
if(NOT DEFINED JULIAVDB_PICTURES OR JULIAVDB_PICTURES)
  juliavdb_dependency(OpenImageIO 2.4 "libopenimageio-dev and openimageio-tools")
endif()
juliavdb_dependency(OpenSSL 3.0 libssl-dev)
juliavdb_dependency(ZLIB 1.2 zlib1g-dev)
juliavdb_dependency(PNG 1.6 libpng-dev)
juliavdb_dependency(PkgConfig "" pkg-config)
if(NOT DEFINED JULIAVDB_PICTURES OR JULIAVDB_PICTURES)
  pkg_check_modules(Cairo REQUIRED cairo-ft freetype2)
endif()
# For 3MF, which needs libzip to be written, and both to be read; without them that format is refused.
pkg_check_modules(LibZip QUIET libzip)
pkg_check_modules(Expat QUIET expat)
# For glTF that is compressed by Draco, which is refused without it.
pkg_check_modules(Draco QUIET draco)
if(Draco_FOUND)
  # The pkg-config file of Draco 1.5.6, which Debian 13 has, names a folder without its prefix.
  find_path(JULIAVDB_DRACO_HEADERS draco/compression/decode.h HINTS ${Draco_INCLUDE_DIRS})
  mark_as_advanced(JULIAVDB_DRACO_HEADERS)
  set(Draco_INCLUDE_DIRS "${JULIAVDB_DRACO_HEADERS}")
  if(NOT JULIAVDB_DRACO_HEADERS)
    set(Draco_FOUND OFF)
  endif()
endif()
# For FBX, DAE, 3DS and X3D, which are refused without it.
pkg_check_modules(Assimp QUIET assimp)
# pkg-config names the compiler's own include folders, too. They must stay where the compiler has them in its order: given
# once more, /usr/include comes before the C++ headers that look for the C headers in the next folder.
set(own_directories "")
foreach(directory IN LISTS CMAKE_CXX_IMPLICIT_INCLUDE_DIRECTORIES)
  file(REAL_PATH "${directory}" directory)
  list(APPEND own_directories "${directory}")
endforeach()
foreach(library Cairo LibZip Expat Draco Assimp)
  set(directories "")
  foreach(directory IN LISTS ${library}_INCLUDE_DIRS)
    file(REAL_PATH "${directory}" real_directory)
    if(NOT real_directory IN_LIST own_directories)
      list(APPEND directories "${directory}")
    endif()
  endforeach()
  set(${library}_INCLUDE_DIRS "${directories}")
endforeach()

juliavdb_dependency(nlohmann_json 3.11 nlohmann-json3-dev)
juliavdb_dependency(meshoptimizer 0.18 libmeshoptimizer-dev)
juliavdb_dependency(muparser 2.3 libmuparser-dev)

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
