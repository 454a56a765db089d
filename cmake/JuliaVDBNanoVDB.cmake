# SPDX-License-Identifier: Apache-2.0
# NanoVDB, which is headers alone: its own version 32, whose layout the reader knows. OpenVDB 10 to 13 bring 32.3 to 32.9.
# JULIAVDB_NO_NANOVDB is the reason if it is not used.
find_path(NanoVDB_INCLUDE_DIR nanovdb/NanoVDB.h HINTS ${OpenVDB_INCLUDE_DIR})
set(JULIAVDB_NO_NANOVDB "")
if(NanoVDB_INCLUDE_DIR)
  file(STRINGS "${NanoVDB_INCLUDE_DIR}/nanovdb/NanoVDB.h" lines REGEX "^#define NANOVDB_(MAJOR|MINOR)_VERSION_NUMBER ")
  string(REGEX REPLACE ".*MAJOR_VERSION_NUMBER +([0-9]+).*MINOR_VERSION_NUMBER +([0-9]+).*" "\\1.\\2" NanoVDB_VERSION "${lines}")
  if(NOT NanoVDB_VERSION MATCHES "^32\\.")
    set(JULIAVDB_NO_NANOVDB "NanoVDB's headers were of version ${NanoVDB_VERSION}, and 32 is needed")
  endif()
else()
  set(JULIAVDB_NO_NANOVDB "NanoVDB's headers were not found (Debian's package libnanovdb-dev)")
endif()
option(JULIAVDB_NANOVDB "Write NanoVDB files, where NanoVDB's headers are (Debian: libnanovdb-dev)" ON)
if(NOT JULIAVDB_NANOVDB)
  set(JULIAVDB_NO_NANOVDB "they were turned off (JULIAVDB_NANOVDB)")
elseif(JULIAVDB_NO_NANOVDB)
  set(JULIAVDB_NANOVDB OFF)  # for this run alone: the headers may be installed later
endif()
juliavdb_part("NanoVDB files" "${JULIAVDB_NANOVDB}" "${JULIAVDB_NO_NANOVDB}")
