// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/gltf_pose.h"

#include "base/json_text.h"
#include "julia/elementary.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using Json = nlohmann::json;
using openvdb::Vec3d;

/// More morph targets than any mesh has.
constexpr std::uint64_t kMostMorphs = 65536;

/// A list of an object; an empty one if there is none.
const Json& listOf(const GltfFile& file, const Json& object, const char* name) {
  static const Json none = Json::array();
  const auto found = object.find(name);
  if (found == object.end()) return none;
  if (!found->is_array()) file.fail("'" + std::string(name) + "' is not a list");
  return *found;
}

const Json& objectOf(const GltfFile& file, const Json& list, std::uint64_t index, const char* what) {
  if (index >= list.size() || !list[index].is_object())
    file.fail(std::string(what) + ' ' + std::to_string(index) + " of an animation is missing");
  return list[index];
}

std::string textOf(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

enum class Between { Step, Linear, Cubic };

/// The keys of one channel: times, and some numbers at each.
class Keys {
 public:
  /// @param width  numbers at a key; 0: as many as there are
  Keys(const GltfFile& file, const Json& sampler, std::uint64_t width) : mFile(file) {
    mTimes = file.array(file.whole(sampler, "input"));
    mValues = file.array(file.whole(sampler, "output"));
    const std::string between = textOf(sampler, "interpolation");
    if (between == "STEP")
      mBetween = Between::Step;
    else if (between == "CUBICSPLINE")
      mBetween = Between::Cubic;
    else if (!between.empty() && between != "LINEAR")
      file.fail("the interpolation of an animation is '" + inOneLine(between) + "', which is unknown");
    if (mTimes.components() != 1 || mTimes.count() == 0) file.fail("an animation has no times");
    for (std::uint64_t i = 0; i < mTimes.count(); ++i)
      if (!std::isfinite(mTimes.value(i, 0)) || (i > 0 && !(mTimes.value(i - 1, 0) < mTimes.value(i, 0))))
        file.fail("the times of an animation do not increase");
    const std::uint64_t blocks = mBetween == Between::Cubic ? 3 : 1;
    const auto components = static_cast<std::uint64_t>(mValues.components());
    const std::uint64_t perKey = mValues.count() / mTimes.count() / blocks * components;
    mWidth = width == 0 ? perKey : width;
    if (perKey != mWidth || mWidth == 0 || mWidth > kMostMorphs || (width > 0 && components != width) ||
        mValues.count() != mWidth / components * blocks * mTimes.count())
      file.fail("an animation has " + std::to_string(mValues.count()) + " values for " +
                std::to_string(mTimes.count()) + " times, which do not fit its path");
  }

  std::vector<double> at(double seconds, bool isRotation) const {
    std::vector<double> result = raw(seconds, isRotation);
    for (const double value : result)
      if (!std::isfinite(value)) mFile.fail("an animation has a value that is not finite");
    if (!isRotation) return result;
    const double length = std::sqrt(dot(result, result));
    if (!(length > 0) || !std::isfinite(length)) mFile.fail("a rotation of an animation has no direction");
    for (double& value : result) value /= length;
    return result;
  }

 private:
  enum Part { Before, Value, After };  ///< of a key of a cubic spline

  static double dot(const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
    return sum;
  }

  std::vector<double> key(std::uint64_t i, Part part = Value) const {
    const std::uint64_t block = mBetween == Between::Cubic ? 3 * i + part : i;
    const auto components = static_cast<std::uint64_t>(mValues.components());
    std::vector<double> numbers(mWidth);
    for (std::uint64_t n = 0; n < mWidth; ++n) {
      const std::uint64_t number = block * mWidth + n;
      numbers[n] = mValues.value(number / components, static_cast<int>(number % components));
    }
    return numbers;
  }

  std::vector<double> raw(double seconds, bool isRotation) const {
    const std::uint64_t last = mTimes.count() - 1;
    if (!(seconds > mTimes.value(0, 0))) return key(0);
    if (seconds >= mTimes.value(last, 0)) return key(last);
    std::uint64_t low = 0, high = last;
    while (high - low > 1) {
      const std::uint64_t middle = low + (high - low) / 2;
      (mTimes.value(middle, 0) <= seconds ? low : high) = middle;
    }
    const double step = mTimes.value(high, 0) - mTimes.value(low, 0), u = (seconds - mTimes.value(low, 0)) / step;
    const std::vector<double> from = key(low);
    if (mBetween == Between::Step) return from;
    const std::vector<double> to = key(high);
    if (mBetween == Between::Linear) return isRotation ? turned(from, to, u) : blended(from, 1 - u, to, u);
    const std::vector<double> leaves = key(low, After), arrives = key(high, Before);
    const double u2 = u * u, u3 = u2 * u;
    std::vector<double> result(mWidth);
    for (std::size_t n = 0; n < result.size(); ++n)
      result[n] = (2 * u3 - 3 * u2 + 1) * from[n] + step * (u3 - 2 * u2 + u) * leaves[n] + (3 * u2 - 2 * u3) * to[n] +
                  step * (u3 - u2) * arrives[n];
    return result;
  }

  static std::vector<double> blended(const std::vector<double>& a, double of, const std::vector<double>& b,
                                     double other) {
    std::vector<double> result(a.size());
    for (std::size_t n = 0; n < result.size(); ++n) result[n] = of * a[n] + other * b[n];
    return result;
  }

  /// Spherical linear interpolation, on the shorter way.
  static std::vector<double> turned(const std::vector<double>& from, const std::vector<double>& to, double u) {
    const double lengths = std::sqrt(dot(from, from)) * std::sqrt(dot(to, to));
    const double cosine = dot(from, to) / lengths, sign = cosine < 0 ? -1 : 1;
    constexpr double kNearlyEqual = 0.9999999;
    if (!(std::abs(cosine) < kNearlyEqual)) return blended(from, 1 - u, to, sign * u);
    const double angle = julia::elementary::acos(std::abs(cosine)), sine = julia::elementary::sin(angle);
    return blended(from, julia::elementary::sin((1 - u) * angle) / sine, to,
                   sign * julia::elementary::sin(u * angle) / sine);
  }

  const GltfFile& mFile;
  GltfArray mTimes, mValues;
  std::uint64_t mWidth = 0;
  Between mBetween = Between::Linear;
};

/// The animations that a moment asks for.
std::vector<std::uint64_t> chosenAnimations(const GltfFile& file, const std::string& name) {
  const std::uint64_t count = file.sizeOf("animations");
  if (count == 0) file.fail("it has no animation; leave --target-frame out");
  std::vector<std::uint64_t> chosen;
  std::string names;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::string known = textOf(file.element("animations", i), "name");
    if (known == name && !name.empty()) return {i};
    constexpr std::uint64_t kMostNamed = 8;
    if (i < kMostNamed)
      names += (i == 0 ? "" : ", ") + (known.empty() ? std::to_string(i) : "'" + inOneLine(known) + "'");
    if (name == "all" || (name.empty() && i == 0)) chosen.push_back(i);
  }
  if (!chosen.empty()) return chosen;
  std::uint64_t number = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
  if (error == std::errc() && end == name.data() + name.size() && number < count) return {number};
  file.fail("it has no animation '" + inOneLine(name) + "'; there is " + names);
}

}  // namespace

Placement placed(const std::vector<double>& t, const std::vector<double>& q, const std::vector<double>& s) {
  Placement result;
  if (!q.empty()) {
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    result.columns[0] = Vec3d(1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w));
    result.columns[1] = Vec3d(2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w));
    result.columns[2] = Vec3d(2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y));
  }
  if (!s.empty())
    for (std::size_t k = 0; k < 3; ++k) result.columns[k] *= s[k];
  if (!t.empty()) result.columns[3] = Vec3d(t[0], t[1], t[2]);
  return result;
}

GltfPose::GltfPose(const GltfFile& file, const std::optional<MeshMoment>& moment) : mFile(file) {
  if (!moment) return;
  for (const std::uint64_t animation : chosenAnimations(file, moment->animation))
    play(file.element("animations", animation), moment->seconds);
}

void GltfPose::play(const Json& animation, double seconds) {
  const Json& channels = listOf(mFile, animation, "channels");
  const Json& samplers = listOf(mFile, animation, "samplers");
  for (std::uint64_t i = 0; i < channels.size(); ++i) {
    const Json& channel = objectOf(mFile, channels, i, "channel");
    const auto target = channel.find("target");
    if (target == channel.end() || !target->is_object()) mFile.fail("a channel of an animation has no target");
    const std::string path = textOf(*target, "path");
    if (path == "pointer") {
      // Of materials, lights and cameras, which are no part of the shape.
      if (target->dump(-1, ' ', true, Json::error_handler_t::replace).find("/nodes/") == std::string::npos) continue;
      mFile.fail("an animation moves nodes by KHR_animation_pointer, which cannot be played; export it without");
    }
    if (!target->contains("node")) continue;
    const std::uint64_t index = mFile.whole(*target, "node");
    const Json& node = mFile.element("nodes", index);
    const bool isMorph = path == "weights", isRotation = path == "rotation";
    if (!isMorph && !isRotation && path != "translation" && path != "scale")
      mFile.fail("an animation changes '" + inOneLine(path) + "' of a node, which cannot be played");
    if (!isMorph && node.contains("matrix"))
      mFile.fail("node " + std::to_string(index) +
                 " has a matrix and is animated; export it with its location, rotation and scale");
    const Keys keys(mFile, objectOf(mFile, samplers, mFile.whole(channel, "sampler"), "sampler"),
                    isMorph      ? 0
                    : isRotation ? 4
                                 : 3);
    Moved& moved = mMoved[index];
    (isMorph           ? moved.weights
     : isRotation      ? moved.rotation
     : path == "scale" ? moved.scale
                       : moved.translation) = keys.at(seconds, isRotation);
  }
}

Placement GltfPose::local(std::uint64_t index) const {
  const Json& node = mFile.element("nodes", index);
  if (const std::vector<double> m = mFile.numbers(node, "matrix", 16); !m.empty()) {
    Placement result;
    for (std::size_t k = 0; k < 4; ++k) result.columns[k] = Vec3d(m[4 * k], m[4 * k + 1], m[4 * k + 2]);
    return result;
  }
  const auto moved = mMoved.find(index);
  const auto part = [&](std::vector<double> Moved::*member, const char* name, std::size_t count) {
    if (moved != mMoved.end() && !(moved->second.*member).empty()) return moved->second.*member;
    return mFile.numbers(node, name, count);
  };
  return placed(part(&Moved::translation, "translation", 3), part(&Moved::rotation, "rotation", 4),
                part(&Moved::scale, "scale", 3));
}

std::vector<double> GltfPose::morphWeights(std::uint64_t index) const {
  if (const auto moved = mMoved.find(index); moved != mMoved.end() && !moved->second.weights.empty())
    return moved->second.weights;
  const Json& node = mFile.element("nodes", index);
  const Json& holder = node.contains("weights") ? node : mFile.element("meshes", mFile.whole(node, "mesh"));
  return mFile.numbers(holder, "weights", listOf(mFile, holder, "weights").size());
}

std::vector<Placement> GltfPose::worldsOf(const std::vector<std::uint64_t>& nodes) const {
  constexpr std::uint64_t kNone = ~std::uint64_t{0};
  const std::uint64_t count = mFile.sizeOf("nodes");
  std::vector<std::uint64_t> parents(count, kNone);
  for (std::uint64_t i = 0; i < count; ++i)
    for (const Json& child : listOf(mFile, mFile.element("nodes", i), "children")) {
      const std::uint64_t number = mFile.whole(Json{{"node", child}}, "node");
      if (number >= count) mFile.fail("node " + std::to_string(number) + " is a child, and there is none");
      if (parents[number] != kNone) mFile.fail("node " + std::to_string(number) + " is the child of two nodes");
      parents[number] = i;
    }
  std::vector<std::optional<Placement>> known(count);
  std::vector<Placement> worlds;
  for (const std::uint64_t node : nodes) {
    std::vector<std::uint64_t> way;
    for (std::uint64_t at = node; at != kNone && !known[at]; at = parents[at]) {
      if (way.size() == count) mFile.fail("node " + std::to_string(node) + " is its own child");
      way.push_back(at);
    }
    for (; !way.empty(); way.pop_back()) {
      const std::uint64_t at = way.back(), parent = parents[at];
      known[at] = parent == kNone ? local(at) : known[parent]->after(local(at));
    }
    worlds.push_back(*known[node]);
  }
  return worlds;
}

std::vector<Placement> GltfPose::jointsOf(std::uint64_t index) const {
  const Json& skin = mFile.element("skins", index);
  std::vector<std::uint64_t> nodes;
  for (const Json& joint : listOf(mFile, skin, "joints")) {
    nodes.push_back(mFile.whole(Json{{"joint", joint}}, "joint"));
    mFile.element("nodes", nodes.back());
  }
  if (nodes.empty()) mFile.fail("skin " + std::to_string(index) + " has no joints");
  std::vector<Placement> joints = worldsOf(nodes);
  if (!skin.contains("inverseBindMatrices")) return joints;
  const GltfArray matrices = mFile.matrices(mFile.whole(skin, "inverseBindMatrices"));
  if (matrices.count() < joints.size()) mFile.fail("skin " + std::to_string(index) + " has fewer matrices than joints");
  for (std::size_t j = 0; j < joints.size(); ++j) {
    Placement bind;
    for (int k = 0; k < 4; ++k)
      bind.columns[static_cast<std::size_t>(k)] =
          Vec3d(matrices.value(j, 4 * k), matrices.value(j, 4 * k + 1), matrices.value(j, 4 * k + 2));
    joints[j] = joints[j].after(bind);
  }
  return joints;
}

GltfShape::GltfShape(const GltfFile& file, const Json& primitive, const std::vector<double>& weights,
                     const std::vector<Placement>& joints, const Placement& placement)
    : mFile(file), mJoints(joints), mPlacement(placement), mMirrors(placement.mirrors()) {
  const Json& attributes = primitive["attributes"];
  mPositions = file.array(file.whole(attributes, "POSITION"));
  if (mPositions.components() != 3) file.fail("positions are not vectors of three numbers");
  const Json& targets = listOf(file, primitive, "targets");
  for (std::size_t k = 0; k < weights.size(); ++k) {
    if (weights[k] == 0) continue;
    if (k >= targets.size() || !targets[k].is_object())
      file.fail("a mesh has " + std::to_string(weights.size()) + " weights for " + std::to_string(targets.size()) +
                " morph targets");
    if (!targets[k].contains("POSITION")) continue;
    const GltfArray moves = file.array(file.whole(targets[k], "POSITION"));
    if (moves.components() != 3 || moves.count() != mPositions.count())
      file.fail("morph target " + std::to_string(k) + " is not a vector for each point");
    mMorphs.emplace_back(weights[k], moves);
  }
  if (joints.empty()) return;
  for (int set = 0;; ++set) {
    const std::string jointsName = "JOINTS_" + std::to_string(set), weightsName = "WEIGHTS_" + std::to_string(set);
    if (!attributes.contains(jointsName)) break;
    const GltfArray numbers = file.array(file.whole(attributes, jointsName.c_str())),
                    shares = file.array(file.whole(attributes, weightsName.c_str()));
    if (!numbers.isUnsigned() || numbers.components() != 4 || shares.components() != 4 ||
        numbers.count() != mPositions.count() || shares.count() != mPositions.count())
      file.fail("'" + jointsName + "' and '" + weightsName + "' are not four numbers for each point");
    mSkin.emplace_back(numbers, shares);
  }
  if (mSkin.empty()) file.fail("a mesh has a skin, and its points have no joints");
  const auto mirrored = std::count_if(joints.begin(), joints.end(), [](const Placement& j) { return j.mirrors(); });
  mMirrors = 2 * static_cast<std::size_t>(mirrored) > joints.size();
}

Vec3d GltfShape::point(std::uint64_t i) const {
  Vec3d p(mPositions.value(i, 0), mPositions.value(i, 1), mPositions.value(i, 2));
  for (const auto& [weight, moves] : mMorphs)
    p += weight * Vec3d(moves.value(i, 0), moves.value(i, 1), moves.value(i, 2));
  if (mSkin.empty()) return mPlacement.point(p);
  Vec3d sum(0);
  double whole = 0;
  for (const auto& [numbers, shares] : mSkin)
    for (int k = 0; k < 4; ++k) {
      const double share = shares.value(i, k);
      if (share == 0) continue;
      const std::uint64_t joint = numbers.index(i, k);
      if (joint >= mJoints.size())
        mFile.fail("a point moves with joint " + std::to_string(joint) + " of " + std::to_string(mJoints.size()));
      sum += share * mJoints[joint].point(p);
      whole += share;
    }
  // The shares of a point should sum to 1; one that has none moves with the first joint.
  return whole > 0 ? sum / whole : mJoints.front().point(p);
}

bool mayBeAnimated(const std::filesystem::path& path) {
  const FileFormat* const format = formatOfMesh(path);
  return format && format->animations;
}

std::vector<MeshAnimation> readAnimations(const std::filesystem::path& path) {
  if (!mayBeAnimated(path)) return {};
  const std::string contents = readWholeFile(path);
  const GltfFile file(path, contents);
  std::vector<MeshAnimation> animations;
  for (std::uint64_t i = 0; i < file.sizeOf("animations"); ++i) {
    const Json& animation = file.element("animations", i);
    MeshAnimation found{.name = textOf(animation, "name")};
    bool isFirst = true;
    for (const Json& sampler : listOf(file, animation, "samplers")) {
      if (!sampler.is_object()) file.fail("a sampler of an animation is not an object");
      const GltfArray times = file.array(file.whole(sampler, "input"));
      if (times.count() == 0 || times.components() != 1) file.fail("an animation has no times");
      const double first = times.value(0, 0), last = times.value(times.count() - 1, 0);
      if (!std::isfinite(first) || !std::isfinite(last)) file.fail("the times of an animation are not finite");
      found.first = isFirst ? first : std::min(found.first, first);
      found.last = isFirst ? last : std::max(found.last, last);
      isFirst = false;
    }
    animations.push_back(found);
  }
  return animations;
}

}  // namespace vdbtools
