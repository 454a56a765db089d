// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/draco_decoder.h"

#ifdef VDBTOOLS_DRACO
#include "vdbtools/base/memory.h"

#include <draco/compression/decode.h>

#include <memory>
#include <optional>
#endif

namespace vdbtools {

#ifndef VDBTOOLS_DRACO

bool canDecodeDraco() { return false; }

DracoShape decodeDraco(std::string_view, std::span<const DracoAttribute>, std::uint64_t&) {
  return {.problem = "this program was built without Draco: " VDBTOOLS_NO_DRACO};
}

#else

namespace {

struct DracoCounts {
  std::uint64_t triangles = 0, points = 0;
};

std::optional<std::uint64_t> nextVarint(std::string_view& bytes) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 35 && !bytes.empty(); shift += 7) {
    const auto byte = static_cast<unsigned char>(bytes.front());
    bytes.remove_prefix(1);
    value |= std::uint64_t{byte & 0x7FU} << shift;
    if ((byte & 0x80U) == 0) return value;
  }
  return std::nullopt;
}

/// The counts in the head of version 2.2, the only one that glTF has. Draco allocates what they ask for. Without a
/// result, the head is of another version or has metadata, which no file of glTF needs.
std::optional<DracoCounts> countsInHead(std::string_view bytes) {
  constexpr std::string_view kHead("DRACO\2\2\1", 8);
  constexpr std::size_t kMethod = 8, kFlags = 9, kHeadSize = 11;
  if (!bytes.starts_with(kHead) || bytes.size() < kHeadSize || bytes[kFlags] != 0 || bytes[kFlags + 1] != 0)
    return std::nullopt;
  const bool isSequential = bytes[kMethod] == 0;
  bytes.remove_prefix(kHeadSize);
  if (!isSequential) bytes.remove_prefix(bytes.empty() ? 0 : 1);  // the kind of traversal
  const auto first = nextVarint(bytes), second = nextVarint(bytes);
  if (!first || !second) return std::nullopt;
  return isSequential ? DracoCounts{*first, *second} : DracoCounts{*second, *first};
}

template <class Number>
bool appendValue(const draco::PointAttribute& attribute, draco::PointIndex point, int components, std::string& bytes) {
  Number values[4] = {};
  if (!attribute.ConvertValue(attribute.mapped_index(point), static_cast<std::int8_t>(components), values))
    return false;
  bytes.append(reinterpret_cast<const char*>(values), static_cast<std::size_t>(components) * sizeof(Number));
  return true;
}

}  // namespace

bool canDecodeDraco() { return true; }

DracoShape decodeDraco(std::string_view bytes, std::span<const DracoAttribute> attributes, std::uint64_t& room) {
  constexpr const char* kDamaged = "it is damaged, or of another version than 2.2";
  const auto counts = countsInHead(bytes);
  if (!counts) return {.problem = kDamaged};
  constexpr std::uint64_t kBytesOfNumber = 4, kBytesOfTriangle = 3 * kBytesOfNumber;
  std::uint64_t ofPoint = kBytesOfTriangle;
  for (const DracoAttribute& attribute : attributes)
    ofPoint += static_cast<std::uint64_t>(attribute.components) * kBytesOfNumber;
  const std::uint64_t needed = counts->triangles * kBytesOfTriangle + counts->points * ofPoint;
  if (needed > room) return {.problem = "it is larger than the file can hold"};
  room -= needed;
  requireMemory(static_cast<double>(needed), MemoryUse::File, "a part of a glTF");

  draco::DecoderBuffer buffer;
  buffer.Init(bytes.data(), bytes.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) return {.problem = kDamaged};
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  DracoShape shape{.points = mesh->num_points()};
  for (std::uint32_t f = 0; f < mesh->num_faces(); ++f)
    for (const draco::PointIndex& point : mesh->face(draco::FaceIndex(f))) shape.corners.push_back(point.value());
  for (const DracoAttribute& wanted : attributes) {
    const draco::PointAttribute* const attribute = mesh->GetAttributeByUniqueId(wanted.id);
    // Draco reads the bytes of truth values, which glTF does not have, without a check.
    if (!attribute || attribute->num_components() != wanted.components || attribute->data_type() == draco::DT_BOOL)
      return {.problem = "its attribute " + std::to_string(wanted.id) + " does not fit the accessor"};
    std::string& values = shape.attributes.emplace_back();
    for (std::uint32_t p = 0; p < mesh->num_points(); ++p) {
      const draco::PointIndex point(p);
      if (attribute->mapped_index(point).value() >= attribute->size() ||
          !(wanted.isWhole ? appendValue<std::uint32_t>(*attribute, point, wanted.components, values)
                           : appendValue<float>(*attribute, point, wanted.components, values)))
        return {.problem = kDamaged};
    }
  }
  return shape;
}

#endif

}  // namespace vdbtools
