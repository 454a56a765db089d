# SPDX-License-Identifier: Apache-2.0
# Interface targets to which every target of the project links privately.

# If multiplications and additions were fused, results would depend on which ones the compiler chose.
# At -O2, the basic-block vectoriser of Debian's g++ 12.2 drops the rounding of double(float(x)) where it finds three of
# these in a row. The results are wrong, not just different, so this pass is turned off.
add_library(juliavdb_flags INTERFACE)
target_compile_options(juliavdb_flags INTERFACE -ffp-contract=off $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)

add_library(juliavdb_warnings INTERFACE)
# Missing initialisers are fine, because members of options structs have defaults. -Wrestrict is off because g++ 12 reports
# overlaps in std::string that do not exist (GCC bug 105651).
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
