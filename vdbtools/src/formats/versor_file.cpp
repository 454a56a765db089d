// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/formats/versor_file.h"

#include "base/json_text.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/peer_formats.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <set>
#include <stdexcept>
#include <vector>

namespace vdbtools {
namespace {

using Json = nlohmann::json;

constexpr const char* kFormat = "rational";
constexpr const char* kWaveFormat = "waves";
constexpr int kVersion = 1;

// The keys of the file.
constexpr const char* kFormatKey = "juliavdb";
constexpr const char* kVersionKey = "version";
constexpr const char* kNoteKey = "note";
constexpr const char* kLogScaleKey = "logScale";
constexpr const char* kTopKey = "top";
constexpr const char* kBottomKey = "bottom";
constexpr const char* kPowerScaleKey = "powerScale";
constexpr const char* kRootsKey = "roots";
constexpr const char* kPositionKey = "position";
constexpr const char* kPowerKey = "power";
constexpr const char* kTargetKey = "target";
constexpr const char* kCentreKey = "centre";
constexpr const char* kScaleKey = "scale";
constexpr const char* kBoxKey = "box";
constexpr const char* kFactorsKey = "factors";
constexpr const char* kWavesKey = "waves";
constexpr const char* kFrequencyKey = "frequency";
constexpr const char* kCosineKey = "cosine";
constexpr const char* kSineKey = "sine";

/// Detects what nlohmann::json's tree cannot show: where a text breaks off, and duplicate keys.
class Syntax : public nlohmann::json_sax<Json> {
 public:
  /// @throw DataError  @a text is not one JSON value
  static void check(std::string_view text, const std::string& name) {
    // The parser takes a zero byte for the end of its input.
    const std::size_t zero = text.find('\0');
    if (zero != std::string_view::npos) {
      throw DataError(name + ": line " + lineOf(text, zero) + " holds a zero byte; this is not a JSON file");
    }
    if (nestsTooDeep(text))
      throw DataError(name + ": it has more than " + std::to_string(kMostJsonDepth) +
                      " levels; this is not a rational");
    Syntax syntax;
    if (Json::sax_parse(text, &syntax)) return;
    const std::string line =
        syntax.mPosition ? " in line " + lineOf(text, std::min(*syntax.mPosition, text.size())) : "";
    throw DataError(name + ": not valid JSON" + line + ": " + inOneLine(syntax.mMessage));
  }

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_object(std::size_t) override {
    mObjects.emplace_back();
    return true;
  }
  bool end_object() override {
    mObjects.pop_back();
    return true;
  }
  bool start_array(std::size_t) override { return true; }
  bool end_array() override { return true; }
  bool key(string_t& key) override {
    Object& object = mObjects.back();
    object.current = key;
    if (object.keys.insert(key).second) return true;
    std::string place;
    for (const Object& outer : mObjects) place += (place.empty() ? "" : ".") + outer.current;
    mMessage = place + " occurs twice in one object";
    return false;
  }
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override {
    mPosition = position;
    mMessage = error.what();
    // The prefix "[json.exception...] " is meant for programmers.
    if (const std::size_t bracket = mMessage.find("] "); mMessage.starts_with('[') && bracket != std::string::npos) {
      mMessage.erase(0, bracket + 2);
    }
    return false;
  }

 private:
  static std::string lineOf(std::string_view text, std::size_t position) {
    return std::to_string(1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(position), '\n'));
  }

  /// An object whose end has not been reached.
  struct Object {
    std::set<std::string> keys;
    std::string current;
  };

  std::vector<Object> mObjects;
  std::string mMessage;
  std::optional<std::size_t> mPosition;
};

/// A value of the tree, with a description of its position.
class Node {
 public:
  Node(const Json& value, std::string name, std::string place)
      : mValue(value), mName(std::move(name)), mPlace(std::move(place)) {}

  /// Checks that this is an object with all of @a required and nothing else but @a optional.
  void requireKeys(std::initializer_list<const char*> required,
                   std::initializer_list<const char*> optional = {}) const {
    requireObject();
    for (const auto& [key, value] : mValue.items()) {
      const auto isKey = [&given = key](const char* known) { return given == known; };
      if (std::none_of(required.begin(), required.end(), isKey) &&
          std::none_of(optional.begin(), optional.end(), isKey)) {
        fail("has the unknown key \"" + inOneLine(key) + "\"; remove it");
      }
    }
    for (const char* key : required) {
      if (!mValue.contains(key)) fail(std::string("has no \"") + key + "\"; it is required");
    }
  }

  bool has(const char* key) const { return mValue.is_object() && mValue.contains(key); }

  Node at(const char* key) const {
    requireObject();
    if (!mValue.contains(key)) fail(std::string("has no \"") + key + "\"; it is required");
    return {mValue[key], mName, (mPlace.empty() ? "" : mPlace + ".") + key};
  }

  std::vector<Node> elements() const {
    if (!mValue.is_array()) fail("is " + found() + "; it must be an array");
    std::vector<Node> nodes;
    nodes.reserve(mValue.size());
    for (std::size_t i = 0; i < mValue.size(); ++i) {
      nodes.emplace_back(mValue[i], mName, mPlace + "[" + std::to_string(i) + "]");
    }
    return nodes;
  }

  double number() const {
    if (!mValue.is_number()) fail("is " + found() + "; it must be a number");
    return mValue.get<double>();
  }

  std::string string() const {
    if (!mValue.is_string()) fail("is " + found() + "; it must be a string");
    return mValue.get<std::string>();
  }

  template <class Value>
  void requireEqual(const Value& expected) const {
    if (mValue != Json(expected)) fail("is " + found() + "; this program reads " + Json(expected).dump());
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(mName + ": " + (mPlace.empty() ? "the file" : mPlace) + " " + what);
  }

 private:
  void requireObject() const {
    if (!mValue.is_object()) fail("is " + found() + "; it must be an object");
  }

  /// A description of the value; for arrays and objects only the kind, because they may be large and deep.
  std::string found() const {
    if (mValue.is_structured()) return mValue.is_array() ? "an array" : "an object";
    return inOneLine(mValue.dump(-1, ' ', false, Json::error_handler_t::replace));
  }

  const Json& mValue;
  std::string mName, mPlace;
};

/// The shortest digits that are read back as the same double, in any locale.
std::string shortestNumber(double value) {
  std::array<char, 32> digits{};
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc()) throw std::logic_error("a double did not fit into 32 characters");
  const std::string text(digits.data(), end);
  // JSON readers take "-0" for an integer, for which 0 has no sign.
  return text == "-0" ? "-0.0" : text;
}

std::vector<double> numbersFrom(const Node& node, std::size_t count) {
  std::vector<double> numbers;
  for (const Node& element : node.elements()) numbers.push_back(element.number());
  if (numbers.size() != count)
    node.fail("has " + std::to_string(numbers.size()) + " numbers; it must have " + std::to_string(count));
  return numbers;
}

FittedTo targetFrom(const Node& node) {
  node.requireKeys({kCentreKey, kScaleKey, kBoxKey});
  const std::vector<double> c = numbersFrom(node.at(kCentreKey), 3), b = numbersFrom(node.at(kBoxKey), 6);
  const double scale = node.at(kScaleKey).number();
  if (!(scale > 0)) node.at(kScaleKey).fail("is " + shortestNumber(scale) + "; it must be above 0");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!(b[axis] < b[axis + 3])) node.at(kBoxKey).fail("has no extent; the smaller corner must come first");
    if (!std::isfinite(b[axis + 3] - b[axis])) node.at(kBoxKey).fail("is too large: its extent is not a finite number");
  }
  return {{{c[0], c[1], c[2]}, scale}, {{b[0], b[1], b[2]}, {b[3], b[4], b[5]}}};
}

/// @throw std::invalid_argument  targetFrom() would reject it
void requireReadable(const FittedTo& target) {
  const openvdb::Vec3d &low = target.box.min(), &high = target.box.max();
  bool readable = target.space.centre.isFinite() && target.space.scale > 0 && std::isfinite(target.space.scale);
  for (int axis = 0; axis < 3; ++axis) readable &= low[axis] < high[axis] && std::isfinite(high[axis] - low[axis]);
  if (!readable)
    throw std::invalid_argument(
        "the fitted shape's centre, scale and box must be finite, its scale above 0 and its "
        "box not empty");
}

julia::Quaternion<double> quaternionFrom(const Node& node) {
  const std::vector<Node> components = node.elements();
  if (components.size() != 4) {
    node.fail("has " + std::to_string(components.size()) + " numbers; it must have 4, A, B, C and D");
  }
  return {components[0].number(), components[1].number(), components[2].number(), components[3].number()};
}

julia::Root rootFrom(const Node& node) {
  node.requireKeys({kPositionKey, kPowerKey});
  return {quaternionFrom(node.at(kPositionKey)), node.at(kPowerKey).number()};
}

julia::WaveFactor waveFactorFrom(const Node& node) {
  node.requireKeys({kPowerKey, kWavesKey});
  const double power = node.at(kPowerKey).number();
  if (power != std::round(power) || !(std::abs(power) <= julia::kMostWavePower))
    node.at(kPowerKey).fail("is " + shortestNumber(power) + "; it must be a whole number of at most " +
                            std::to_string(julia::kMostWavePower));
  julia::WaveFactor factor{{}, static_cast<int>(power)};
  for (const Node& wave : node.at(kWavesKey).elements()) {
    wave.requireKeys({kFrequencyKey, kCosineKey, kSineKey});
    factor.waves.push_back({quaternionFrom(wave.at(kFrequencyKey)), quaternionFrom(wave.at(kCosineKey)),
                            quaternionFrom(wave.at(kSineKey))});
  }
  return factor;
}

julia::Polynomial polynomialFrom(const Node& node) {
  node.requireKeys({kPowerScaleKey, kRootsKey});
  julia::Polynomial polynomial;
  polynomial.powerScale = node.at(kPowerScaleKey).number();
  for (const Node& root : node.at(kRootsKey).elements()) polynomial.roots.push_back(rootFrom(root));
  return polynomial;
}

std::string numberList(std::initializer_list<double> numbers) { return joined(numbers, ", ", shortestNumber); }

std::string quoted(const char* word) { return '"' + std::string(word) + "\": "; }

std::string quaternionText(const julia::Quaternion<double>& q) { return '[' + numberList({q.a, q.b, q.c, q.d}) + ']'; }

/// The beginning of a file.
std::string headText(const char* format, std::string_view note) {
  std::string text =
      "{\n  " + quoted(kFormatKey) + '"' + format + "\",\n  " + quoted(kVersionKey) + std::to_string(kVersion) + ",\n";
  if (!note.empty())
    text += "  " + quoted(kNoteKey) + Json(note).dump(-1, ' ', false, Json::error_handler_t::replace) + ",\n";
  return text;
}

void appendPolynomial(std::string& text, const char* key, const julia::Polynomial& polynomial) {
  text += "  " + quoted(key) + "{\n    " + quoted(kPowerScaleKey) + shortestNumber(polynomial.powerScale) + ",\n    " +
          quoted(kRootsKey) + "[";
  const char* separator = "\n";
  for (const julia::Root& root : polynomial.roots) {
    text += separator;
    text += "      {" + quoted(kPositionKey) + quaternionText(root.position) + ", " + quoted(kPowerKey) +
            shortestNumber(root.power) + "}";
    separator = ",\n";
  }
  text += polynomial.roots.empty() ? "]\n  }" : "\n    ]\n  }";
}

bool holdsWaves(const Json& tree) {
  return tree.is_object() && tree.contains(kFormatKey) && tree[kFormatKey] == kWaveFormat;
}

}  // namespace

RationalFile rationalFileFromJson(std::string_view text, const std::string& nameForErrors) {
  const std::string name = inOneLine(nameForErrors);
  Syntax::check(text, name);
  const Json tree = Json::parse(text);
  const Node root(tree, name, "");
  if (holdsWaves(tree)) root.fail("holds waves and no roots; as a texture, give it as waves:" + name);
  // The kind of file is checked first, because a later version may well have other keys.
  root.at(kFormatKey).requireEqual(kFormat);
  root.at(kVersionKey).requireEqual(kVersion);
  root.requireKeys({kFormatKey, kVersionKey, kLogScaleKey, kTopKey, kBottomKey}, {kNoteKey, kTargetKey});

  RationalFile file;
  if (root.has(kNoteKey)) file.note = root.at(kNoteKey).string();
  file.rational.logScale = root.at(kLogScaleKey).number();
  file.rational.top = polynomialFrom(root.at(kTopKey));
  file.rational.bottom = polynomialFrom(root.at(kBottomKey));
  if (root.has(kTargetKey)) file.target = targetFrom(root.at(kTargetKey));
  try {
    julia::requireFinite(file.rational);
  } catch (const std::invalid_argument& error) {
    throw DataError(name + ": " + error.what());
  }
  return file;
}

std::string rationalToJson(const julia::Rational& rational, std::string_view note,
                           const std::optional<FittedTo>& target) {
  julia::requireFinite(rational);
  if (target) requireReadable(*target);
  std::string text = headText(kFormat, note) + "  " + quoted(kLogScaleKey) + shortestNumber(rational.logScale) + ",\n";
  appendPolynomial(text, kTopKey, rational.top);
  text += ",\n";
  appendPolynomial(text, kBottomKey, rational.bottom);
  if (target) {
    const openvdb::Vec3d &centre = target->space.centre, &low = target->box.min(), &high = target->box.max();
    text += ",\n  \"" + std::string(kTargetKey) + "\": {\"" + kCentreKey + "\": [" +
            numberList({centre[0], centre[1], centre[2]}) + "], \"" + kScaleKey +
            "\": " + shortestNumber(target->space.scale) + ", \"" + kBoxKey + "\": [" +
            numberList({low[0], low[1], low[2], high[0], high[1], high[2]}) + "]}";
  }
  text += "\n}\n";
  return text;
}

WaveFile waveFileFromJson(std::string_view text, const std::string& nameForErrors) {
  const std::string name = inOneLine(nameForErrors);
  Syntax::check(text, name);
  const Json tree = Json::parse(text);
  const Node root(tree, name, "");
  root.at(kFormatKey).requireEqual(kWaveFormat);
  root.at(kVersionKey).requireEqual(kVersion);
  root.requireKeys({kFormatKey, kVersionKey, kFactorsKey}, {kNoteKey});
  WaveFile file;
  if (root.has(kNoteKey)) file.note = root.at(kNoteKey).string();
  for (const Node& factor : root.at(kFactorsKey).elements()) file.waves.factors.push_back(waveFactorFrom(factor));
  try {
    julia::requireValid(file.waves);
  } catch (const std::invalid_argument& error) {
    throw DataError(name + ": " + error.what());
  }
  return file;
}

WaveFile readWaveFile(const std::filesystem::path& path) {
  return waveFileFromJson(readWholeFile(path), path.string());
}

std::string wavesToJson(const julia::WaveTexture& waves, std::string_view note) {
  julia::requireValid(waves);
  std::string text = headText(kWaveFormat, note) + "  " + quoted(kFactorsKey) + "[";
  const char* separator = "\n";
  for (const julia::WaveFactor& factor : waves.factors) {
    text += separator;
    text += "    {" + quoted(kPowerKey) + std::to_string(factor.power) + ", " + quoted(kWavesKey) + "[";
    const char* between = "\n";
    for (const julia::Wave& wave : factor.waves) {
      text += between;
      text += "      {" + quoted(kFrequencyKey) + quaternionText(wave.frequency) + ", " + quoted(kCosineKey) +
              quaternionText(wave.cosine) + ", " + quoted(kSineKey) + quaternionText(wave.sine) + "}";
      between = ",\n";
    }
    text += "\n    ]}";
    separator = ",\n";
  }
  return text + "\n  ]\n}\n";
}

RationalFile readRationalFile(const std::filesystem::path& path) {
  const std::string extension = lowerExtension(path);
  if (extension == ".json") return rationalFileFromJson(readWholeFile(path), path.string());
  if (extension == ".p4d" || extension == ".poly4d") {
    RationalFile file;
    file.rational.top = readPolynomial(path);
    return file;
  }
  if (extension == ".o3d") return {readOptimisedShape(path).rational, {}, {}};
  throw std::invalid_argument("cannot tell what kind of file " + inOneLine(path.native()) + " is by its extension \"" +
                              inOneLine(extension) + "\"; a rational is read from .json, .p4d, .poly4d or .o3d");
}

julia::Rational readRational(const std::filesystem::path& path) { return readRationalFile(path).rational; }

std::variant<RationalFile, WaveFile> readVersorFile(const std::filesystem::path& path) {
  if (lowerExtension(path) != ".json") return readRationalFile(path);
  const std::string text = readWholeFile(path);
  Syntax::check(text, inOneLine(path.string()));
  if (holdsWaves(Json::parse(text))) return waveFileFromJson(text, path.string());
  return rationalFileFromJson(text, path.string());
}

}  // namespace vdbtools
