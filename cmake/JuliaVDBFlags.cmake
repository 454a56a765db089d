# SPDX-License-Identifier: Apache-2.0
# Interface targets that every target of the project links privately.

# Contraction to fused multiply-adds would make results depend on what the compiler fused.
# Debian's g++ 12.2 drops the rounding of double(float(x)) when its basic-block vectoriser sees three of them in a row
# (at -O2; wrong results, not just other ones), so that pass is off.
add_library(juliavdb_flags INTERFACE)
target_compile_options(juliavdb_flags INTERFACE -ffp-contract=off $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)

add_library(juliavdb_warnings INTERFACE)
# Missing initialisers: options structs have defaults, that is their point. Restrict: g++ 12 sees overlaps in std::string
# that are not there (GCC bug 105651).
target_compile_options(juliavdb_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-missing-field-initializers
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(JULIAVDB_WERROR)
  target_compile_options(juliavdb_warnings INTERFACE -Werror)
endif()

if(JULIAVDB_SANITIZE)
  add_compile_options(-fsanitize=${JULIAVDB_SANITIZE} -fno-omit-frame-pointer -g)
  add_link_options(-fsanitize=${JULIAVDB_SANITIZE})
endif()
