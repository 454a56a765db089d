// SPDX-License-Identifier: Apache-2.0
#include "support/limits.h"
#include "support/temporary_folder.h"

#include "vdbtools/formats/peer_formats.h"

#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;
using test_limits::kInfinity;
using test_limits::kNan;

std::string int32(std::int32_t value) {
  std::string bytes;
  for (int i = 0; i < 4; ++i) bytes += static_cast<char>(static_cast<std::uint32_t>(value) >> (8 * i));
  return bytes;
}

std::string float64(double value) {
  std::string bytes;
  for (int i = 0; i < 8; ++i) bytes += static_cast<char>(std::bit_cast<std::uint64_t>(value) >> (8 * i));
  return bytes;
}

/// A polynomial as the released programs write it, with every number open to lies.
struct PeerPolynomial {
  std::vector<std::vector<double>> roots{{0.25, -1, 2, 0.5}, {1, 2, 3, 4}, {-0.125, 0, 0, 0}};
  std::vector<double> powers{1.5, -2, 7};
  double scalar = 2;
  int unusedCount = 2;
  double unusedValue = 1e300;
  std::int32_t degree = 3;
  std::int32_t unusedCountStated = 2, rootsStated = 3, powersStated = 3;

  std::string bytes() const {
    std::string text = int32(degree);
    for (int array = 0; array < 3; ++array) {
      text += int32(array == 1 ? unusedCountStated : unusedCount);
      for (int i = 0; i < 4 * unusedCount; ++i) text += float64(i % 2 == 0 ? unusedValue : kNan);
    }
    text += int32(rootsStated);
    for (const auto& root : roots)
      for (const double component : root) text += float64(component);
    text += int32(powersStated);
    for (const double power : powers) text += float64(power);
    return text + float64(scalar);
  }

  julia::Polynomial expected() const {
    julia::Polynomial polynomial;
    for (std::size_t i = 0; i < roots.size(); ++i)
      polynomial.roots.push_back({{roots[i][0], roots[i][1], roots[i][2], roots[i][3]}, powers[i]});
    polynomial.powerScale = scalar;
    return polynomial;
  }
};

PeerPolynomial emptyPeer(std::int32_t degree) {
  PeerPolynomial peer;
  peer.roots.clear();
  peer.powers.clear();
  peer.degree = degree;
  peer.rootsStated = peer.powersStated = 0;
  return peer;
}

struct PeerField {
  std::vector<std::int32_t> resolutions{2, 1, 3};
  int values = 6;

  std::string bytes() const {
    std::string text;
    for (const std::int32_t resolution : resolutions) text += int32(resolution);
    for (int i = 0; i < 6; ++i) text += float64(i);
    for (int i = 0; i < values; ++i) text += float64(kNan);
    return text;
  }
};

struct PeerShape {
  std::vector<std::int32_t> resolutions{4, 5, 6};
  std::vector<double> centre{0.5, -1, 2}, lengths{1, 2, 3};
  PeerPolynomial top, bottom;
  double scale = std::exp(-3.5);
  std::int32_t history = 12;
  PeerField fractal, distance, potential;

  std::string bytes() const {
    std::string text;
    for (const std::int32_t resolution : resolutions) text += int32(resolution);
    for (const double coordinate : centre) text += float64(coordinate);
    for (const double length : lengths) text += float64(length);
    return text + top.bytes() + bottom.bytes() + float64(scale) + int32(history) + fractal.bytes() + distance.bytes() +
           potential.bytes();
  }
};

/// The message of the DataError that reading @a bytes throws; it must be one line and name the file.
template <class Read>
std::string peerRefusal(Read read, const std::string& bytes) {
  try {
    read(bytes, "folder/some file");
  } catch (const DataError& error) {
    const std::string text = error.what();
    EXPECT_TRUE(text.starts_with("folder/some file: ")) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return text;
  }
  ADD_FAILURE() << "accepted";
  return {};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(P4d, GivesRootsPowersAndScale) {
  const PeerPolynomial peer;
  EXPECT_EQ(polynomialFromP4d(peer.bytes(), "x"), peer.expected());
  const julia::Root root = polynomialFromP4d(peer.bytes(), "x").roots[1];
  EXPECT_EQ(root.position, (julia::Quaternion<double>{1, 2, 3, 4}));  // w, x, y, z
  EXPECT_EQ(root.power, -2);
}

TEST(P4d, ReadsPolynomialsWithoutRootsOrCoefficients) {
  for (const std::int32_t degree : {0, -1}) {
    PeerPolynomial peer = emptyPeer(degree);
    EXPECT_EQ(polynomialFromP4d(peer.bytes(), "x"), peer.expected()) << degree;
    peer.unusedCount = peer.unusedCountStated = 0;
    EXPECT_EQ(polynomialFromP4d(peer.bytes(), "x"), peer.expected()) << degree;
  }
}

TEST(P4d, RefusesEveryPrefixAndEveryTail) {
  const std::string bytes = PeerPolynomial().bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE(size);
    peerRefusal(polynomialFromP4d, bytes.substr(0, size));
  }
  for (const std::size_t size : {1, 3, 8, 32}) {
    SCOPED_TRACE(size);
    EXPECT_TRUE(contains(peerRefusal(polynomialFromP4d, bytes + std::string(size, '\0')), "bytes follow"));
  }
  peerRefusal(polynomialFromP4d, bytes + bytes);
}

// Promise: Files of the released programs ...
TEST(P4d, RefusesCountsThatLie) {
  for (const std::int32_t lie :
       {-1, 0, 1, 2, 4, 100, 0x04000000, 0x08000000, 0x10000000, 0x7FFFFFFF, -0x7FFFFFFF - 1}) {
    SCOPED_TRACE(lie);
    const auto refused = [](const std::function<void(PeerPolynomial&)>& change) {
      PeerPolynomial peer;
      change(peer);
      return peerRefusal(polynomialFromP4d, peer.bytes());
    };
    refused([lie](PeerPolynomial& peer) { peer.rootsStated = lie; });
    refused([lie](PeerPolynomial& peer) { peer.powersStated = lie; });
    refused([lie](PeerPolynomial& peer) { peer.degree = lie; });
    if (lie != 2) refused([lie](PeerPolynomial& peer) { peer.unusedCountStated = lie; });
  }
  PeerPolynomial peer;
  peer.rootsStated = -7;
  EXPECT_TRUE(
      contains(peerRefusal(polynomialFromP4d, peer.bytes()), "the number of roots of the top polynomial is -7"));
}

TEST(P4d, RefusesCoefficientsWithoutRoots) {
  EXPECT_TRUE(contains(peerRefusal(polynomialFromP4d, emptyPeer(2).bytes()), "factored"));
}

TEST(P4d, RefusesNumbersThatCannotBeUsed) {
  for (const double bad : {kNan, kInfinity, -kInfinity, 1.0000001e9, -1e300}) {
    SCOPED_TRACE(bad);
    for (std::size_t component = 0; component < 4; ++component) {
      PeerPolynomial peer;
      peer.roots[1][component] = bad;
      EXPECT_TRUE(contains(peerRefusal(polynomialFromP4d, peer.bytes()), "top root 1"));
    }
    PeerPolynomial peer;
    peer.powers[2] = bad;
    EXPECT_TRUE(contains(peerRefusal(polynomialFromP4d, peer.bytes()), "top root 2"));
    peer = {};
    peer.scalar = bad;
    EXPECT_TRUE(contains(peerRefusal(polynomialFromP4d, peer.bytes()), "power scale"));
  }
  PeerPolynomial peer;
  peer.powers[0] = peer.scalar = 1e6;  // each is in bounds, their product is not
  peerRefusal(polynomialFromP4d, peer.bytes());
}

// Promise of peer-formats.md: Files of the released programs are read and written to the byte; counts are held "against
//   the length of the file"
TEST(P4d, ComesBackAsItWasWritten) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> number(-1e9, 1e9);
  for (const std::size_t count : {0, 1, 2, 77}) {
    julia::Polynomial polynomial;
    for (std::size_t i = 0; i < count; ++i)
      polynomial.roots.push_back({{number(random), -0.0, number(random) * 1e-300, 5e-324}, number(random)});
    polynomial.powerScale = 1.0 / 3;
    const std::string bytes = rationalToP4d(polynomial);
    EXPECT_EQ(bytes.size(), 6 * 4 + count * 5 * 8 + 8);
    EXPECT_EQ(polynomialFromP4d(bytes, "x"), polynomial) << count;
    EXPECT_EQ(rationalToP4d(polynomialFromP4d(bytes, "x")), bytes) << count;
  }
}

TEST(P4d, DoesNotWriteWhatCannotBeRead) {
  for (const double bad : {kNan, kInfinity, 2e9}) {
    julia::Polynomial polynomial;
    polynomial.roots.push_back({{0, bad, 0, 0}, 1});
    EXPECT_THROW(rationalToP4d(polynomial), std::invalid_argument) << bad;
  }
}

TEST(O3d, GivesTheShape) {
  PeerShape peer;
  peer.bottom.scalar = -0.5;
  const OptimisedShape shape = optimisedShapeFromO3d(peer.bytes(), "x");
  EXPECT_EQ(shape.resolutions, (std::array<int, 3>{4, 5, 6}));
  EXPECT_EQ(shape.centre, (std::array<double, 3>{0.5, -1, 2}));
  EXPECT_EQ(shape.lengths, (std::array<double, 3>{1, 2, 3}));
  EXPECT_EQ(shape.rational.top, peer.top.expected());
  EXPECT_EQ(shape.rational.bottom, peer.bottom.expected());
  EXPECT_DOUBLE_EQ(shape.rational.logScale, -3.5);
}

TEST(O3d, ReadsEmptyPartsAndExtremeScales) {
  PeerShape peer;
  peer.bottom = emptyPeer(-1);
  peer.history = 0;
  peer.fractal = {{0, 0, 0}, 0};
  peer.potential = {{0x7FFFFFFF, 0x7FFFFFFF, 0}, 0};
  for (const double scale : {5e-324, 1.0, std::numeric_limits<double>::max()}) {
    peer.scale = scale;
    EXPECT_EQ(optimisedShapeFromO3d(peer.bytes(), "x").rational.logScale, std::log(scale));
  }
}

TEST(O3d, RefusesEveryPrefixAndEveryTail) {
  const std::string bytes = PeerShape().bytes();
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    SCOPED_TRACE(size);
    peerRefusal(optimisedShapeFromO3d, bytes.substr(0, size));
  }
  peerRefusal(optimisedShapeFromO3d, bytes + '\0');
  peerRefusal(optimisedShapeFromO3d, bytes + float64(0));
}

// Promise: Files of the released programs ...
TEST(O3d, RefusesFieldsThatLie) {
  const std::int32_t most = 0x7FFFFFFF;
  const std::vector<std::vector<std::int32_t>> lies{{-2, 1, 3},
                                                    {2, -1, -3},
                                                    {2, 1, 4},
                                                    {2, 1, 2},
                                                    {0, 1, 3},
                                                    {most, most, most},
                                                    {1, 1, most},
                                                    {most, 1, 1},
                                                    {0x10000, 0x10000, 0x10000},
                                                    {-1, -1, 0},
                                                    {1 << 30, 1 << 30, 16},
                                                    {-most - 1, 1, 1}};
  for (const auto& lie : lies) {
    SCOPED_TRACE(::testing::PrintToString(lie));
    for (PeerField PeerShape::*const field : {&PeerShape::fractal, &PeerShape::distance, &PeerShape::potential}) {
      PeerShape peer;
      (peer.*field).resolutions = lie;
      peerRefusal(optimisedShapeFromO3d, peer.bytes());
    }
  }
}

TEST(O3d, RefusesNumbersThatCannotBeUsed) {
  const auto refused = [](const std::function<void(PeerShape&)>& change) {
    PeerShape peer;
    change(peer);
    return peerRefusal(optimisedShapeFromO3d, peer.bytes());
  };
  for (const double bad : {0.0, -0.0, -1.0, kNan, kInfinity}) {
    SCOPED_TRACE(bad);
    EXPECT_TRUE(contains(refused([bad](PeerShape& peer) { peer.scale = bad; }), "e^C"));
    EXPECT_TRUE(contains(refused([bad](PeerShape& peer) { peer.lengths[2] = bad; }), "length"));
  }
  for (const double bad : {kNan, kInfinity, 1e10}) {
    SCOPED_TRACE(bad);
    EXPECT_TRUE(contains(refused([bad](PeerShape& peer) { peer.centre[0] = bad; }), "centre"));
    EXPECT_TRUE(contains(refused([bad](PeerShape& peer) { peer.bottom.roots[0][3] = bad; }), "bottom root 0"));
  }
  for (const std::int32_t bad : {0, -1}) {
    EXPECT_TRUE(contains(refused([bad](PeerShape& peer) { peer.resolutions[1] = bad; }), "resolutions"));
  }
  EXPECT_TRUE(contains(refused([](PeerShape& peer) { peer.history = -1; }), "history"));
}

TEST(O3d, SurvivesNoise) {
  // Any bytes are read or refused; the sanitizers watch.
  std::mt19937_64 random(2);
  const std::string good = PeerShape().bytes();
  for (int i = 0; i < 20000; ++i) {
    std::string bytes = good;
    for (std::uint64_t changes = 1 + random() % 3; changes > 0; --changes)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    try {
      optimisedShapeFromO3d(bytes, "x");
    } catch (const DataError&) {
    }
  }
}

/// A shape of 2 x 3 x 2 cells with a field of 12 values that tell their places apart.
OptimisedShape writtenShape() {
  PeerPolynomial bottom;
  bottom.roots = {{5, -6, 7, -8}};
  bottom.powers = {0.75};
  bottom.scalar = -0.5;
  return {{2, 3, 2}, {0.5, -1, 2}, {1, 2, 3}, {-3.5, PeerPolynomial().expected(), bottom.expected()}};
}

std::vector<double> cellValues(double first) {
  std::vector<double> values;
  for (int i = 0; i < 12; ++i) values.push_back(first + i);
  return values;
}

// Promise: Files of the released programs ...
TEST(O3d, IsWrittenByteForByte) {
  const OptimisedShape shape = writtenShape();
  const std::string box =
      int32(2) + int32(3) + int32(2) + float64(0.5) + float64(-1) + float64(2) + float64(1) + float64(2) + float64(3);
  PeerPolynomial top, bottom;
  top.unusedCount = top.unusedCountStated = bottom.unusedCount = bottom.unusedCountStated = 0;
  bottom.degree = bottom.rootsStated = bottom.powersStated = 1;
  bottom.roots = {{5, -6, 7, -8}};
  bottom.powers = {0.75};
  bottom.scalar = -0.5;
  std::string expected = box + top.bytes() + bottom.bytes() + float64(std::exp(-3.5)) + int32(0);
  for (const double first : {100., -1e300, 0.5}) {
    expected += box;
    for (const double value : cellValues(first)) expected += float64(value);
  }
  EXPECT_EQ(optimisedShapeToO3d(shape, cellValues(100), cellValues(-1e300), cellValues(0.5)), expected);
}

TEST(O3d, ComesBackAsItWasWritten) {
  for (const double logScale : {-3.5, 0., 1.0 / 3, -708.0, 709.0}) {
    for (const bool empty : {false, true}) {
      OptimisedShape shape = writtenShape();
      shape.rational.logScale = logScale;
      if (empty) shape.rational.bottom = {};
      std::vector<double> values = cellValues(1);
      values[3] = kNan;
      values[4] = -kInfinity;
      const std::string bytes = optimisedShapeToO3d(shape, values, values, values);
      const OptimisedShape back = optimisedShapeFromO3d(bytes, "x");
      EXPECT_EQ(back.resolutions, shape.resolutions);
      EXPECT_EQ(back.centre, shape.centre);
      EXPECT_EQ(back.lengths, shape.lengths);
      EXPECT_EQ(back.rational.top, shape.rational.top);
      EXPECT_EQ(back.rational.bottom, shape.rational.bottom);
      EXPECT_NEAR(back.rational.logScale, logScale, 4e-16 * (1 + std::abs(logScale)));
    }
  }
}

TEST(O3d, DoesNotWriteWhatCannotBeRead) {
  const std::vector<double> good = cellValues(1);
  const auto refused = [&](const std::function<void(OptimisedShape&)>& change) -> std::string {
    OptimisedShape shape = writtenShape();
    change(shape);
    try {
      optimisedShapeToO3d(shape, good, good, good);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    ADD_FAILURE() << "accepted";
    return {};
  };
  for (const double bad : {-709.0, 710.0, 1e8, -1e8}) {
    const std::string text = refused([bad](OptimisedShape& shape) { shape.rational.logScale = bad; });
    EXPECT_TRUE(contains(text, ".json")) << text;
  }
  EXPECT_TRUE(contains(refused([](OptimisedShape& shape) { shape.rational.logScale = 710; }), "C is 710"));
  for (const double bad : {kNan, kInfinity, 2e9}) {
    refused([bad](OptimisedShape& shape) { shape.rational.logScale = bad; });
    refused([bad](OptimisedShape& shape) { shape.rational.bottom.roots[0].power = bad; });
    refused([bad](OptimisedShape& shape) { shape.centre[1] = bad; });
    refused([bad](OptimisedShape& shape) { shape.lengths[1] = bad; });
  }
  refused([](OptimisedShape& shape) { shape.lengths[2] = 0; });
  for (const int bad : {0, -1, 1, 3, 0x7FFFFFFF}) refused([bad](OptimisedShape& shape) { shape.resolutions[2] = bad; });
  refused([](OptimisedShape& shape) { shape.resolutions = {0x40000000, 0x40000000, 0x40000000}; });
  const std::vector<double> many(13), none;
  for (const std::vector<double>& bad : {many, none}) {
    EXPECT_THROW(optimisedShapeToO3d(writtenShape(), bad, good, good), std::invalid_argument);
    EXPECT_THROW(optimisedShapeToO3d(writtenShape(), good, bad, good), std::invalid_argument);
    EXPECT_THROW(optimisedShapeToO3d(writtenShape(), good, good, bad), std::invalid_argument);
  }
}

TEST(PeerFiles, AreReadFromPaths) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "shape";
  std::ofstream(path, std::ios::binary) << PeerPolynomial().bytes();
  EXPECT_EQ(readPolynomial(path), PeerPolynomial().expected());
  EXPECT_THROW(readOptimisedShape(path), DataError);
  std::ofstream(path, std::ios::binary) << PeerShape().bytes();
  EXPECT_EQ(readOptimisedShape(path).rational.top, PeerPolynomial().expected());
  EXPECT_THROW(readPolynomial(path), DataError);
  EXPECT_THROW(readPolynomial(folder.path()), MissingInputError);
  EXPECT_THROW(readOptimisedShape(path / "below"), MissingInputError);
}

}  // namespace
}  // namespace vdbtools
