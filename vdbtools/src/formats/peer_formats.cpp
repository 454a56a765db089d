// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/formats/peer_formats.h"

#include "base/elementary.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr std::size_t kIntSize = 4;
constexpr std::size_t kDoubleSize = 8;
constexpr std::size_t kQuaternionSize = 4 * kDoubleSize;
constexpr double kLargestCoordinate = 1e9;  ///< as in julia::requireFinite()

std::string textOf(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Reads the bytes of a file in order, and throws at their end.
class Reader {
 public:
  Reader(std::string_view bytes, const std::string& name) : mBytes(bytes), mName(inOneLine(name)) {}

  std::int32_t readInt(const std::string& what) {
    return std::bit_cast<std::int32_t>(static_cast<std::uint32_t>(readLittleEndian(kIntSize, what)));
  }

  double readDouble(const std::string& what) {
    return std::bit_cast<double>(std::uint64_t{readLittleEndian(kDoubleSize, what)});
  }

  /// Reads a count of elements of @a elementSize bytes and checks that all of them follow.
  std::size_t readCount(const std::string& elements, std::size_t elementSize) {
    const std::int32_t count = readInt("the number of " + elements);
    const std::size_t most = left() / elementSize;
    if (count < 0 || static_cast<std::size_t>(count) > most) {
      fail("the number of " + elements + " is " + std::to_string(count) + "; the rest of the file has room for 0 to " +
           std::to_string(most));
    }
    return static_cast<std::size_t>(count);
  }

  void skip(std::size_t size, const std::string& what) {
    if (size > left()) {
      fail("it ends within " + what + ": " + std::to_string(size) + " bytes are needed from byte " +
           std::to_string(mPosition) + " on, and the file has " + std::to_string(mBytes.size()));
    }
    mPosition += size;
  }

  void requireEnd() const {
    if (left() == 0) return;
    fail(std::to_string(left()) + " bytes follow where the content ends, at byte " + std::to_string(mPosition) +
         "; there should be none");
  }

  std::size_t left() const { return mBytes.size() - mPosition; }

  [[noreturn]] void fail(const std::string& found) const { throw DataError(mName + ": " + found); }

 private:
  std::uint64_t readLittleEndian(std::size_t size, const std::string& what) {
    const std::size_t begin = mPosition;
    skip(size, what);
    std::uint64_t value = 0;
    for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(mBytes[begin + i]);
    return value;
  }

  std::string_view mBytes;
  std::string mName;
  std::size_t mPosition = 0;
};

julia::Quaternion<double> readQuaternion(Reader& reader, const std::string& what) {
  // One statement per component: the order of reading is that of the file.
  julia::Quaternion<double> q;
  q.a = reader.readDouble(what);
  q.b = reader.readDouble(what);
  q.c = reader.readDouble(what);
  q.d = reader.readDouble(what);
  return q;
}

/// @param side  "top" or "bottom"
julia::Polynomial readPolynomial(Reader& reader, const std::string& side) {
  const std::string of = " of the " + side + " polynomial";
  const std::int32_t statedRoots = reader.readInt("the degree" + of);
  for (const char* unused : {"coefficients", "first derivatives", "second derivatives"}) {
    const std::size_t count = reader.readCount(unused + of, kQuaternionSize);
    reader.skip(count * kQuaternionSize, "the " + (unused + of));
  }

  julia::Polynomial polynomial;
  const std::size_t roots = reader.readCount("roots" + of, kQuaternionSize);
  // A polynomial given only by coefficients has a degree and no roots; it would pass for the constant 1. A polynomial
  // that was never set may have any negative degree.
  if (roots != static_cast<std::size_t>(std::max(statedRoots, 0))) {
    reader.fail("the degree" + of + " is " + std::to_string(statedRoots) + ", but " + std::to_string(roots) +
                " roots follow; only factored polynomials, with a root a degree, can be used");
  }
  polynomial.roots.resize(roots);
  for (julia::Root& root : polynomial.roots) root.position = readQuaternion(reader, "the roots" + of);

  const std::size_t powers = reader.readCount("powers" + of, kDoubleSize);
  if (powers != roots) {
    reader.fail("the number of powers" + of + " is " + std::to_string(powers) + "; it must be that of its roots, " +
                std::to_string(roots));
  }
  for (julia::Root& root : polynomial.roots) root.power = reader.readDouble("the powers" + of);
  polynomial.powerScale = reader.readDouble("the scalar of the powers" + of);
  return polynomial;
}

void requireUsable(const julia::Rational& rational, const Reader& reader) {
  try {
    julia::requireFinite(rational);
  } catch (const std::invalid_argument& error) {
    reader.fail(error.what());
  }
}

void skipField(Reader& reader, const std::string& field) {
  std::uint64_t cells = 1;
  for (const char* axis : {"x", "y", "z"}) {
    const std::string what = "the " + field + " field's resolution in " + axis;
    const std::int32_t resolution = reader.readInt(what);
    if (resolution < 0) reader.fail(what + " is " + std::to_string(resolution) + "; it must not be negative");
    // Capped at "more than the file has", so that no product overflows.
    const std::uint64_t tooMany = reader.left() / kDoubleSize + 1;
    const auto size = static_cast<std::uint64_t>(resolution);
    cells = size != 0 && cells > tooMany / size ? tooMany : cells * size;
  }
  reader.skip(6 * kDoubleSize, "the " + field + " field's centre and lengths");
  if (cells > reader.left() / kDoubleSize) {
    reader.fail("it ends within the " + field + " field's values, or that field's resolutions are wrong: " +
                std::to_string(reader.left()) + " bytes are left for them");
  }
  reader.skip(static_cast<std::size_t>(cells) * kDoubleSize, "the " + field + " field's values");
}

void appendLittleEndian(std::string& bytes, std::uint64_t value, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xFF);
}

void appendDouble(std::string& bytes, double value) {
  appendLittleEndian(bytes, std::bit_cast<std::uint64_t>(value), kDoubleSize);
}

void appendInt(std::string& bytes, int value) {
  appendLittleEndian(bytes, static_cast<std::uint32_t>(value), kIntSize);
}

/// @param format  the file's format, for the message
void appendRoots(std::string& bytes, const julia::Polynomial& polynomial, const char* format) {
  const std::size_t count = polynomial.roots.size();
  if (count > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw std::invalid_argument("a polynomial with " + std::to_string(count) + " roots cannot be written as " + format +
                                ", which holds at most 2147483647");
  }
  appendLittleEndian(bytes, count, kIntSize);
  for (int unused = 0; unused < 3; ++unused) appendInt(bytes, 0);
  appendLittleEndian(bytes, count, kIntSize);
  for (const julia::Root& root : polynomial.roots) {
    for (const double component : {root.position.a, root.position.b, root.position.c, root.position.d}) {
      appendDouble(bytes, component);
    }
  }
  appendLittleEndian(bytes, count, kIntSize);
  for (const julia::Root& root : polynomial.roots) appendDouble(bytes, root.power);
  appendDouble(bytes, polynomial.powerScale);
}

/// Appends the resolutions, the centre and the lengths, with which the shape and each of its fields begin.
void appendBox(std::string& bytes, const OptimisedShape& shape) {
  for (const int resolution : shape.resolutions) appendInt(bytes, resolution);
  for (const double coordinate : shape.centre) appendDouble(bytes, coordinate);
  for (const double length : shape.lengths) appendDouble(bytes, length);
}

void requireWritable(const OptimisedShape& shape) {
  for (const int resolution : shape.resolutions) {
    if (resolution < 1) {
      throw std::invalid_argument("one of the shape's resolutions is " + std::to_string(resolution) +
                                  "; it must be at least 1");
    }
  }
  for (const double coordinate : shape.centre) {
    if (!(std::abs(coordinate) <= kLargestCoordinate)) {
      throw std::invalid_argument("a coordinate of the shape's centre is " + textOf(coordinate) +
                                  "; it must be between -1e9 and 1e9");
    }
  }
  for (const double length : shape.lengths) {
    if (!(length > 0 && length <= kLargestCoordinate)) {
      throw std::invalid_argument("one of the shape's lengths is " + textOf(length) +
                                  "; it must be above 0 and at most 1e9");
    }
  }
  julia::requireFinite(shape.rational);
  if (!std::isnormal(elementary::exp(shape.rational.logScale))) {
    throw std::invalid_argument("the constant C is " + textOf(shape.rational.logScale) +
                                "; an o3d holds e^C as a double, which reaches from about -708 to 709; write .json, "
                                "which holds C itself");
  }
}

void requireOneValueACell(const OptimisedShape& shape, std::size_t values, const char* field) {
  std::size_t left = values;
  bool whole = true;
  for (const int resolution : shape.resolutions) {
    const auto size = static_cast<std::size_t>(resolution);
    whole = whole && left % size == 0;
    left /= size;
  }
  if (whole && left == 1) return;
  throw std::invalid_argument(std::string("the ") + field + " field has " + std::to_string(values) +
                              " values; it must have " + std::to_string(shape.resolutions[0]) + " x " +
                              std::to_string(shape.resolutions[1]) + " x " + std::to_string(shape.resolutions[2]));
}

}  // namespace

julia::Polynomial polynomialFromP4d(std::string_view bytes, const std::string& name) {
  Reader reader(bytes, name);
  julia::Rational rational;
  rational.top = readPolynomial(reader, "top");
  reader.requireEnd();
  requireUsable(rational, reader);
  return rational.top;
}

OptimisedShape optimisedShapeFromO3d(std::string_view bytes, const std::string& name) {
  Reader reader(bytes, name);
  OptimisedShape shape;
  for (int& resolution : shape.resolutions) {
    resolution = reader.readInt("the shape's resolutions");
    if (resolution < 1) {
      reader.fail("one of the shape's resolutions is " + std::to_string(resolution) + "; it must be at least 1");
    }
  }
  // Conditions are written so that a NaN fails them.
  for (double& coordinate : shape.centre) {
    coordinate = reader.readDouble("the shape's centre");
    if (!(std::abs(coordinate) <= kLargestCoordinate)) {
      reader.fail("a coordinate of the shape's centre is " + textOf(coordinate) + "; it must be between -1e9 and 1e9");
    }
  }
  for (double& length : shape.lengths) {
    length = reader.readDouble("the shape's lengths");
    if (!(length > 0 && length <= kLargestCoordinate)) {
      reader.fail("one of the shape's lengths is " + textOf(length) + "; it must be above 0 and at most 1e9");
    }
  }

  shape.rational.top = readPolynomial(reader, "top");
  shape.rational.bottom = readPolynomial(reader, "bottom");
  const double scale = reader.readDouble("the constant e^C");
  if (!(scale > 0 && scale <= std::numeric_limits<double>::max())) {
    reader.fail("the constant e^C is " + textOf(scale) + "; it must be above 0 and finite");
  }
  shape.rational.logScale = elementary::log(scale);
  const std::int32_t history = reader.readInt("the history count");
  if (history < 0) reader.fail("the history count is " + std::to_string(history) + "; it must not be negative");

  for (const char* field : {"fractal", "distance", "potential"}) skipField(reader, field);
  reader.requireEnd();
  requireUsable(shape.rational, reader);
  return shape;
}

julia::Polynomial readPolynomial(const std::filesystem::path& path) {
  return polynomialFromP4d(readWholeFile(path), path.string());
}

OptimisedShape readOptimisedShape(const std::filesystem::path& path) {
  return optimisedShapeFromO3d(readWholeFile(path), path.string());
}

std::string rationalToP4d(const julia::Polynomial& polynomial) {
  julia::Rational rational;
  rational.top = polynomial;
  julia::requireFinite(rational);
  std::string bytes;
  appendRoots(bytes, polynomial, "p4d");
  return bytes;
}

std::string optimisedShapeToO3d(const OptimisedShape& shape, std::span<const double> fractal,
                                std::span<const double> distance, std::span<const double> potential) {
  requireWritable(shape);
  requireOneValueACell(shape, fractal.size(), "fractal");
  requireOneValueACell(shape, distance.size(), "distance");
  requireOneValueACell(shape, potential.size(), "potential");

  std::string bytes;
  appendBox(bytes, shape);
  appendRoots(bytes, shape.rational.top, "o3d");
  appendRoots(bytes, shape.rational.bottom, "o3d");
  appendDouble(bytes, elementary::exp(shape.rational.logScale));
  appendInt(bytes, 0);
  for (const std::span<const double> field : {fractal, distance, potential}) {
    appendBox(bytes, shape);
    for (const double value : field) appendDouble(bytes, value);
  }
  return bytes;
}

}  // namespace vdbtools
