# SPDX-License-Identifier: Apache-2.0
# juliavdb_dependency(NAME OLDEST PACKAGE [arguments of find_package]) finds a library as find_dependency() does. In a build
# of this project, a library that is missing or older than OLDEST ends configuring with one line, which names Debian's
# package of it. OLDEST is the oldest version that was tried (docs/platforms.md), or "" where a library tells no version.
include(CMakeFindDependencyMacro)

# Ends configuring if a library is missing, or is older than it may be.
function(juliavdb_require name there version oldest package)
  set(needed "${name}")
  if(oldest)
    set(needed "${name} ${oldest} or later")
  endif()
  if(NOT there)
    message(FATAL_ERROR "${needed} is needed, and was not found (Debian's package ${package})")
  elseif(oldest AND version AND version VERSION_LESS oldest)
    message(FATAL_ERROR "${needed} is needed, and ${version} was found (Debian 12 and later have it as ${package})")
  endif()
endfunction()

macro(juliavdb_dependency name oldest package)
  if(CMAKE_FIND_PACKAGE_NAME)
    find_dependency(${name} ${ARGN})
  else()
    find_package(${name} QUIET ${ARGN})
    string(TOUPPER "${name}" juliavdb_upper)
    foreach(juliavdb_version IN ITEMS ${name}_VERSION ${juliavdb_upper}_VERSION ${name}_VERSION_STRING)
      if(DEFINED ${juliavdb_version})
        break()
      endif()
    endforeach()
    juliavdb_require("${name}" "${${name}_FOUND}" "${${juliavdb_version}}" "${oldest}" "${package}")
  endif()
endmacro()
