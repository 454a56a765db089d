// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/formats/file_formats.h"

#include "formats/grid_formats.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <fstream>
#include <ostream>
#include <sstream>
#include <stdexcept>

namespace vdbtools {
namespace {

const GridFormat* gridRow(const FileFormat& format) {
  for (const GridFormat& row : kGridFormats)
    if (row.facts.extension == format.extension) return &row;
  return nullptr;
}

}  // namespace

FormatList fileFormats() {
  static const std::vector<const FileFormat*> formats = [] {
    std::vector<const FileFormat*> all;
    for (const GridFormat& row : kGridFormats) all.push_back(&row.facts);
    all.insert(all.end(), meshFormats().begin(), meshFormats().end());
    return all;
  }();
  return formats;
}

const FileFormat* findFormat(std::string_view name) { return formatByName(fileFormats(), name); }

const FileFormat* formatOfInput(const std::filesystem::path& path) {
  return isStandardInput(path) ? formatOfMesh(path) : findFormat(path.native());
}

std::string extensionsOf(bool FileFormat::*fact) { return formatTexts(fileFormats(), fact, &FileFormat::extension); }

std::string namesOf(bool FileFormat::*fact) { return formatTexts(fileFormats(), fact, &FileFormat::name); }

std::vector<std::string> writtenFormats() {
  std::vector<std::string> names;
  for (const FileFormat* format : fileFormats())
    if ((format->writesGrids || format->writesMesh) && (!format->isBuilt || format->isBuilt()))
      names.emplace_back(format->extension.substr(1));
  return names;
}

const FileFormat& gridFormat(const std::filesystem::path& path) {
  const FileFormat* const format = findFormat(path.native());
  if (format && format->writesGrids) return *format;
  throw std::invalid_argument("'" + path.string() + "' is not a format of grids that can be written; use " +
                              extensionsOf(&FileFormat::writesGrids));
}

void requireBuilt(const FileFormat& format) {
  if (!format.isBuilt || format.isBuilt()) return;
  std::ostringstream nothing;
  if (format.writesGrids)
    writeGrids(nothing, format, {}, {});
  else
    writeMesh(nothing, {}, {.format = &format});
}

FileTexts readFileTexts(const std::filesystem::path& path) {
  const FileFormat* const format = formatOfInput(path);
  const GridFormat* const grids = format ? gridRow(*format) : nullptr;
  if (!grids) return readMeshTexts(path);
  if (grids->texts) return grids->texts(path);
  openToRead(path);  // for its errors
  return {};
}

FileTexts fileTexts(std::string_view name, std::string_view bytes) {
  const FileFormat* const format = findFormat(name);
  if (!format) return {};
  if (const GridFormat* const grids = gridRow(*format))
    return grids->textsOfHead ? grids->textsOfHead(bytes) : FileTexts();
  std::istringstream stream{std::string(bytes)};
  return meshTexts(*format, stream);
}

std::vector<NvdbWritten> writeGrids(std::ostream& stream, const FileFormat& format,
                                    const std::vector<openvdb::GridBase::Ptr>& grids, const VdbWriteOptions& options,
                                    NvdbValues values) {
  const GridFormat* const row = gridRow(format);
  if (!row) throw std::invalid_argument(std::string(format.name) + " holds no grids; write a .vdb");
  return row->write(stream, grids, options, values);
}

bool isVdbPath(const std::filesystem::path& path) {
  const FileFormat* const format = findFormat(path.native());
  return format && format->readsGrids;
}

bool isNvdbPath(const std::filesystem::path& path) {
  const FileFormat* const format = findFormat(path.native());
  return format && format->nvdbBits;
}

}  // namespace vdbtools
