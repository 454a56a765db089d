# SPDX-License-Identifier: Apache-2.0
# Interface targets to which every target of the project links privately.

# If multiplications and additions were fused, results would depend on which ones the compiler chose.
# At -O2, the basic-block vectoriser of Debian's g++ 12.2 drops the rounding of double(float(x)) where it finds three of
# these in a row. The results are wrong, not just different, so this pass is turned off.
add_library(juliavdb_flags INTERFACE)
target_compile_options(juliavdb_flags INTERFACE -ffp-contract=off $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)
# g++ collects its garbage each time its memory has doubled, from 128 MB on, which is a tenth of the time. A GB is there.
target_compile_options(juliavdb_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-heapsize=1048576>)

add_library(juliavdb_warnings INTERFACE)
# Missing initialisers are fine, because members of options structs have defaults. The other warnings are off because g++
# 12 reports overlaps and overflows in `"text" + std::string` that do not exist (GCC bug 105651).
set(gcc12_string_bug $<AND:$<CXX_COMPILER_ID:GNU>,$<VERSION_LESS:$<CXX_COMPILER_VERSION>,13>>)
target_compile_options(juliavdb_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-missing-field-initializers
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  $<${gcc12_string_bug}:-Wno-array-bounds> $<${gcc12_string_bug}:-Wno-stringop-overflow>
  $<${gcc12_string_bug}:-Wno-stringop-overread>)
if(CMAKE_UNITY_BUILD)  # sources that are compiled as one see each other's unnamed namespaces
  target_compile_options(juliavdb_warnings INTERFACE -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
if(JULIAVDB_WERROR)
  target_compile_options(juliavdb_warnings INTERFACE -Werror)
endif()

# Any finding of a sanitizer ends the program. `undefined` leaves out conversions of numbers that do not fit, which are bugs
# here, too; and what `vptr` needs is missing in OpenVDB's library, whose classes are derived from. Line tables are all that
# a report needs: full debug information of OpenVDB's templates would be a gigabyte.
function(juliavdb_sanitize checks)
  if(checks MATCHES "undefined")
    string(APPEND checks ",float-cast-overflow")
    set(without -fno-sanitize=vptr)
    if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
      list(APPEND without -fsanitize-ignorelist=${PROJECT_SOURCE_DIR}/tests/sanitized/ignored.txt)
    endif()
  endif()
  add_compile_options(-fsanitize=${checks} ${without} -fno-sanitize-recover=all -fno-omit-frame-pointer -g1)
  add_link_options(-fsanitize=${checks} ${without})
endfunction()

# Lets ThreadSanitizer see the timed locks of a program.
function(juliavdb_show_timed_locks program)
  if(JULIAVDB_SANITIZE MATCHES "thread")
    target_sources(${program} PRIVATE ${PROJECT_SOURCE_DIR}/tests/sanitized/timed_locks.cpp)
  endif()
endfunction()

if(JULIAVDB_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "JULIAVDB_FUZZ needs clang, for its libFuzzer: cmake --preset fuzz, or "
                        "-DCMAKE_CXX_COMPILER=clang++ (Debian: clang and libclang-rt-dev)")
  endif()
  if(JULIAVDB_SANITIZE)
    message(FATAL_ERROR "JULIAVDB_FUZZ brings its own sanitizers; leave JULIAVDB_SANITIZE empty")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)
  juliavdb_sanitize(address,undefined)
elseif(JULIAVDB_SANITIZE)
  juliavdb_sanitize(${JULIAVDB_SANITIZE})
endif()

# Numbers of 128 bits, with which tests compare. They are a part of GCC, whose own headers no other compiler searches.
add_library(juliavdb_quadmath INTERFACE)
target_link_libraries(juliavdb_quadmath INTERFACE quadmath)
if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  find_program(JULIAVDB_GXX g++)
  if(JULIAVDB_GXX)
    execute_process(COMMAND ${JULIAVDB_GXX} -print-file-name=include/quadmath.h
                    OUTPUT_VARIABLE quadmath_header OUTPUT_STRIP_TRAILING_WHITESPACE)
    file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/quadmath/quadmath.h CONTENT "#include \"${quadmath_header}\"\n")
    target_include_directories(juliavdb_quadmath SYSTEM INTERFACE ${PROJECT_BINARY_DIR}/quadmath)
  endif()
endif()

# For targets that read, write and call others: to optimise them takes longer than it ever gives back. At this level, g++
# believes that a std::optional is read where it is empty.
add_library(juliavdb_light INTERFACE)
target_compile_options(juliavdb_light INTERFACE $<$<CONFIG:Release,RelWithDebInfo>:-O1>
                                                $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)

# Precompiles OpenVDB's grids for a target. The header takes as long to make as it saves in five files, so that of
# `vdbtools_grids` serves all targets at -O1. g++ demands the same options for the header and for what uses it: another
# level of optimisation makes it crash, a macro of the header's command line has to be on the other's, and the code
# has to be of one kind, so programs are compiled as libraries are.
#
# g++ compiles the classes of OpenVDB's math/Maps.h again in every source that includes a grid, 2 s each: their first
# virtual functions are inline. `#pragma interface` leaves them to OpenVDB's own library. It counts for the file that it
# stands in, and #line says that this is Maps.h; if the path should differ, nothing but the time is lost.
#
# @param MAKE  makes the header for this target
# @param OWN   the target's options differ from those of `vdbtools_grids`: makes its own header, or none in a unity build
# @param ARGN  what else the target's sources include; a build that is no unity build precompiles it with the grids
function(juliavdb_precompile target)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "MAKE;OWN" "" "")
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(maps ${PROJECT_BINARY_DIR}/openvdb_maps.h)
    file(CONFIGURE OUTPUT ${maps} CONTENT "#line 1 \"${OpenVDB_INCLUDE_DIR}/openvdb/math/Maps.h\"\n#pragma interface\n")
  endif()
  if(ARG_MAKE OR (NOT CMAKE_UNITY_BUILD AND (ARG_OWN OR ARG_UNPARSED_ARGUMENTS)))
    target_precompile_headers(${target} PRIVATE ${maps} <vdbtools/base/grids.h> ${ARG_UNPARSED_ARGUMENTS})
  elseif(NOT ARG_OWN)
    target_precompile_headers(${target} REUSE_FROM vdbtools_grids)
    target_compile_options(${target} PRIVATE -fPIC)
  elseif(maps)
    target_compile_options(${target} PRIVATE "SHELL:-include ${maps}")
  endif()
endfunction()

# Makes the rest of the arguments, files, bytes of a target: its sources include the header, in the target's binary folder.
function(juliavdb_embed target header)
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${header})
  add_custom_command(
    OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DFILES=${ARGN}" -DOUTPUT=${output} -P ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBEmbed.cmake
    DEPENDS ${ARGN} ${PROJECT_SOURCE_DIR}/cmake/JuliaVDBEmbed.cmake
    VERBATIM)
  target_sources(${target} PRIVATE ${output})
endfunction()

# For unity builds (CMAKE_UNITY_BUILD=ON, as `quickstart` and `run-tests` do), which compile several sources as one file:
# most of the time goes into what OpenVDB's and JSON's headers bring to each. The sources of a folder are taken together,
# in the order of the list, as long as they are not too large for a file that is compiled in half a minute. Two of them
# that define the same private function do not compile. Call this last.
function(juliavdb_unity target)
  get_target_property(libraries ${target} LINK_LIBRARIES)
  if("juliavdb_light" IN_LIST libraries)
    set(most 120000)  # bytes
  else()
    set(most 70000)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    if(NOT source MATCHES "\\.cpp$")
      continue()
    endif()
    get_filename_component(path ${source} ABSOLUTE)
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "${folder}" folder)
    file(SIZE ${path} bytes)
    math(EXPR total_${folder} "0${total_${folder}} + ${bytes}")
    if(NOT DEFINED number_${folder} OR total_${folder} GREATER most)
      math(EXPR number_${folder} "0${number_${folder}} + 1")
      set(total_${folder} ${bytes})
    endif()
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP "${folder}_${number_${folder}}")
  endforeach()
endfunction()
