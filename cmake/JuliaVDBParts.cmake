# SPDX-License-Identifier: Apache-2.0
# Parts that a build may lack, with the reason, which configuring names at its end and the program gives when it is asked
# for them.

# Notes that a part is in the build, or why it is not: juliavdb_part("3MF files" ${LibZip_FOUND} "libzip was not found").
function(juliavdb_part name built reason)
  if(NOT built)
    string(REPLACE ";" "\\;" reason "${reason}")
    set_property(GLOBAL APPEND PROPERTY JULIAVDB_LEFT_OUT "${name}: ${reason}")
  endif()
endfunction()

# Names the parts that are left out. quickstart and run-tests look for these lines.
function(juliavdb_name_parts)
  get_property(parts GLOBAL PROPERTY JULIAVDB_LEFT_OUT)
  foreach(part IN LISTS parts)
    message(STATUS "Left out: ${part}")
  endforeach()
endfunction()
