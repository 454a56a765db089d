// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_writer.h"

#include "vdbtools/base/errors.h"

#include <charconv>
#include <stdexcept>
#include <string_view>

#ifdef VDBTOOLS_LIBZIP
#include <zip.h>

#include <memory>
#include <new>
#endif

namespace vdbtools {

#ifndef VDBTOOLS_LIBZIP

bool canWrite3mf() { return false; }

std::string encode3mf(const Mesh&, const std::map<std::string, std::string>&) {
  throw std::invalid_argument("this program was built without 3MF files: " VDBTOOLS_NO_LIBZIP "; write .stl instead");
}

#else

namespace {

constexpr const char* kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
)";
constexpr const char* kRelationships =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="rel0" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
)";

/// Escapes text between tags or in an attribute.
std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      default: result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    }
  }
  return result;
}

template <class Number>
void appendNumber(std::string& text, std::string_view before, Number number) {
  char digits[32];
  text += before;
  text.append(digits, std::to_chars(digits, digits + sizeof digits, number).ptr);
}

std::string modelXml(const Mesh& mesh, const std::map<std::string, std::string>& metadata) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"millimeter\" xml:lang=\"en-US\" "
      "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
      "xmlns:juliavdb=\"https://juliavdb.invalid/2026\">\n<metadata name=\"Application\">JuliaVDB</metadata>\n";
  for (const auto& [name, value] : metadata)
    text += "<metadata name=\"juliavdb:" + escaped(name) + "\">" + escaped(value) + "</metadata>\n";
  text += "<resources>\n<object id=\"1\" type=\"model\">\n<mesh>\n<vertices>\n";
  for (const openvdb::Vec3d& p : mesh.points) {
    appendNumber(text, "<vertex x=\"", static_cast<float>(p[0]));
    appendNumber(text, "\" y=\"", static_cast<float>(p[1]));
    appendNumber(text, "\" z=\"", static_cast<float>(p[2]));
    text += "\"/>\n";
  }
  text += "</vertices>\n<triangles>\n";
  for (const openvdb::Vec3I& t : mesh.triangles) {
    appendNumber(text, "<triangle v1=\"", t[0]);
    appendNumber(text, "\" v2=\"", t[1]);
    appendNumber(text, "\" v3=\"", t[2]);
    text += "\"/>\n";
  }
  text += "</triangles>\n</mesh>\n</object>\n</resources>\n<build>\n<item objectid=\"1\"/>\n</build>\n</model>\n";
  return text;
}

[[noreturn]] void fail(const std::string& what) { throw IoError("making the zip of a 3MF broke off: " + what); }

[[noreturn]] void fail(zip_error_t* error) {
  if (zip_error_code_zip(error) == ZIP_ER_MEMORY) throw std::bad_alloc();
  fail(std::string(zip_error_strerror(error)));
}

/// @param text  must outlive the archive
void addFile(zip_t* archive, const char* name, std::string_view text) {
  zip_source_t* source = zip_source_buffer(archive, text.data(), text.size(), 0);
  if (!source) fail(zip_get_error(archive));
  const zip_int64_t index = zip_file_add(archive, name, source, ZIP_FL_ENC_UTF_8);
  if (index < 0) {
    zip_source_free(source);
    fail(zip_get_error(archive));
  }
  // 1 January 1980, the first day that a zip can represent, so that the same mesh gives the same bytes.
  constexpr zip_uint16_t kTime = 0, kDay = 0x21;
  const auto at = static_cast<zip_uint64_t>(index);
  constexpr zip_uint32_t kFastest = 1;
  if (zip_file_set_dostime(archive, at, kTime, kDay, 0) != 0 ||
      zip_set_file_compression(archive, at, ZIP_CM_DEFLATE, kFastest) != 0)
    fail(zip_get_error(archive));
}

}  // namespace

bool canWrite3mf() { return true; }

std::string encode3mf(const Mesh& mesh, const std::map<std::string, std::string>& metadata) {
  const std::string model = modelXml(mesh, metadata);
  zip_error_t error;
  zip_error_init(&error);
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> memory(
      zip_source_buffer_create(nullptr, 0, 0, &error), zip_source_free);
  if (!memory) fail(&error);
  zip_source_keep(memory.get());
  zip_t* archive = zip_open_from_source(memory.get(), ZIP_TRUNCATE, &error);
  if (!archive) {
    zip_source_free(memory.get());
    fail(&error);
  }
  try {
    addFile(archive, "[Content_Types].xml", kContentTypes);
    addFile(archive, "_rels/.rels", kRelationships);
    addFile(archive, "3D/3dmodel.model", model);
    if (zip_close(archive) != 0) fail(zip_get_error(archive));
  } catch (...) {
    zip_discard(archive);
    throw;
  }
  zip_stat_t stat;
  if (zip_source_stat(memory.get(), &stat) != 0 || zip_source_open(memory.get()) != 0)
    fail(zip_source_error(memory.get()));
  std::string bytes(stat.size, '\0');
  const zip_int64_t read = zip_source_read(memory.get(), bytes.data(), bytes.size());
  zip_source_close(memory.get());
  if (read < 0 || static_cast<zip_uint64_t>(read) != stat.size) fail("its end could not be read");
  return bytes;
}

#endif

}  // namespace vdbtools
