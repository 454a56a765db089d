// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_formats.h"

#include "mesh_files/mesh_encoder.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <fstream>
#include <stdexcept>
#include <vector>

namespace vdbtools {

FormatList meshFormats() {
  static const std::vector<const FileFormat*> facts = [] {
    std::vector<const FileFormat*> all;
    for (const MeshFormat& row : meshRows()) all.push_back(&row.facts);
    return all;
  }();
  return facts;
}

const MeshFormat& rowOf(const FileFormat& format) {
  for (const MeshFormat& row : meshRows())
    if (row.facts.extension == format.extension) return row;
  throw std::logic_error(std::string(format.name) + " is no format of meshes");
}

const FileFormat& meshFormat(const std::filesystem::path& path) {
  const FileFormat* const format = formatByName(meshFormats(), path.native());
  if (format && format->writesMesh) return *format;
  throw std::invalid_argument("'" + path.string() + "' is not a mesh format that can be written; use one of " +
                              formatTexts(meshFormats(), &FileFormat::writesMesh, &FileFormat::extension));
}

const FileFormat* formatOfMesh(const std::filesystem::path& path) {
  if (!isStandardInput(path)) return formatByName(meshFormats(), path.native());
  constexpr std::size_t kHeadSize = 1 << 16;  // bytes; comments may precede what tells a format apart
  std::string head(kHeadSize, '\0');
  std::ifstream stream = openToRead(path);
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(stream.gcount()));
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(pathToOpen(path), error);
  for (const MeshFormat& row : meshRows())
    if (row.begins && row.begins(head, error ? 0 : size)) return &row.facts;
  return formatByName(meshFormats(), ".obj");
}

FileTexts readMeshTexts(const std::filesystem::path& path) {
  std::ifstream file = openToRead(path);
  const FileFormat* const format = formatOfMesh(path);
  if (!format) return {};
  FileTexts texts = meshTexts(*format, file);
  if (file.bad()) throw IoError("reading '" + path.string() + "' broke off");
  return texts;
}

FileTexts meshTexts(const FileFormat& format, std::istream& stream) {
  const MeshFormat& row = rowOf(format);
  return row.texts ? row.texts(stream) : FileTexts();
}

}  // namespace vdbtools
