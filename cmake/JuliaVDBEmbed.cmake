# SPDX-License-Identifier: Apache-2.0
# Run as a script: writes the files FILES (a list) into the header OUTPUT, each as an array of bytes with its name.
set(arrays "")
set(entries "")
set(number 0)
foreach(file IN LISTS FILES)
  file(READ "${file}" bytes HEX)
  string(LENGTH "${bytes}" digits)
  math(EXPR size "${digits} / 2")
  # Lines of 40 bytes: some compilers are slow with very long ones.
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "0x\\1," bytes "${bytes}")
  string(REPEAT "....." 40 line)
  string(REGEX REPLACE "(${line})" "\\1\n" bytes "${bytes}")
  get_filename_component(name "${file}" NAME)
  string(APPEND arrays "constexpr unsigned char kBytes${number}[] = {\n${bytes}0};\n")
  string(APPEND entries "    {\"${name}\", kBytes${number}, ${size}},\n")
  math(EXPR number "${number} + 1")
endforeach()
file(WRITE "${OUTPUT}"
  "// Made by cmake/JuliaVDBEmbed.cmake.\nstruct EmbeddedBytes {\n  const char* name;\n  const unsigned char* bytes;\n  std::size_t size;\n};\n${arrays}constexpr EmbeddedBytes kEmbedded[] = {\n${entries}};\n")
