// SPDX-License-Identifier: Apache-2.0
#include "picture/embedded_fonts.h"

// The assembler includes the files; as lists of numbers they would take a compiler many seconds. JULIAVDB_FONTS is
// their folder.
#define JULIAVDB_FONT(name, file)                                                   \
  extern "C" [[gnu::visibility("hidden")]] const unsigned char name[], name##End[]; \
  asm(".pushsection .rodata\n" #name ":\n.incbin \"" JULIAVDB_FONTS "/" file "\"\n" #name "End:\n.popsection\n")

JULIAVDB_FONT(juliavdbFont, "DejaVuSans.ttf");
JULIAVDB_FONT(juliavdbBoldFont, "DejaVuSans-Bold.ttf");

namespace vdbtools {

std::span<const unsigned char> embeddedFont(bool isBold) {
  return isBold ? std::span(juliavdbBoldFont, juliavdbBoldFontEnd) : std::span(juliavdbFont, juliavdbFontEnd);
}

}  // namespace vdbtools
