// SPDX-License-Identifier: Apache-2.0
// A formula over the position, the shape of the target, and the attributes of its mesh.
#include "control/control_kinds.h"
#include "control/control_lattice.h"
#include "distance/wide_distance.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"

#include "julia/expression.h"

#include <openvdb/tools/Interpolation.h>

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;
using Values = std::vector<float>;

constexpr const char* kVariables = "x, y, z, nx, ny, nz, phi, tau, curvature, height, hx, hy, hz";

/// What expressions know about a target, on the nodes of a lattice. Each part is computed on first use.
class Surroundings {
 public:
  Surroundings(const ControlLattice& lattice, const ControlContext& context)
      : mLattice(lattice), mContext(context), mLongest(longestSide(context.targetBox)) {}

  /// Distances as fractions of the target's longest side.
  const Values& phi() {
    if (!mPhi.empty()) return mPhi;
    const Target target{.phi = std::const_pointer_cast<openvdb::FloatGrid>(mContext.phi),  // it is only read
                        .box = mContext.targetBox,
                        .denseBox = std::nullopt};
    const Coord& size = mLattice.size;
    Monitor monitor;
    const Vec3d last = mLattice.world((size - Coord(1)).asVec3d());
    const WideDistance wide(target, {mLattice.first, last}, monitor);
    mPhi.resize(mLattice.count());
    mLattice.forEachRow([&](int x, int y) {
      std::vector<Vec3d> points;
      for (int z = 0; z < size[2]; ++z) points.push_back(mLattice.world(Vec3d(x, y, z)));
      std::vector<double> distances(points.size());
      wide.sample(points, distances);
      for (int z = 0; z < size[2]; ++z)
        mPhi[mLattice.index(x, y, z)] = static_cast<float>(distances[static_cast<std::size_t>(z)] / mLongest);
    });
    return mPhi;
  }

  /// One component of the unit vector along which phi grows fastest; 0 where phi is flat.
  const Values& normal(int axis) {
    if (mNormals[0].empty()) {
      const Values& of = phi();
      for (Values& component : mNormals) component.resize(mLattice.count());
      forEachNode([&](const Coord& node, std::size_t index) {
        Vec3d gradient(slope(of, node, 0), slope(of, node, 1), slope(of, node, 2));
        if (!gradient.normalize()) gradient = Vec3d(0);
        for (int a = 0; a < 3; ++a) mNormals[static_cast<std::size_t>(a)][index] = static_cast<float>(gradient[a]);
      });
    }
    return mNormals[static_cast<std::size_t>(axis)];
  }

  /// The mean curvature of the surface near the point closest to each node: half the divergence of its unit normals.
  const Values& curvature() {
    if (!mCurvature.empty()) return mCurvature;
    const Values& distance = phi();
    for (int axis = 0; axis < 3; ++axis) normal(axis);
    Values here(mLattice.count());
    forEachNode([&](const Coord& node, std::size_t index) {
      here[index] = static_cast<float>(
          (slope(mNormals[0], node, 0) + slope(mNormals[1], node, 1) + slope(mNormals[2], node, 2)) / 2);
    });
    smooth(mLattice, here);  // the edges between triangles are not features of the shape
    mCurvature.resize(mLattice.count());
    const double voxels = mLongest / mLattice.voxel;
    forEachNode([&](const Coord& node, std::size_t index) {
      const Vec3d away(mNormals[0][index], mNormals[1][index], mNormals[2][index]);
      const Vec3d nearest = node.asVec3d() - away * (distance[index] * voxels);
      mCurvature[index] = static_cast<float>(mLattice.read(here, nearest));
    });
    return mCurvature;
  }

  /// Thickness as fractions of the target's longest side.
  const Values& tau() {
    if (!mTau.empty()) return mTau;
    if (!mContext.tau) throw std::logic_error("an expression refers to tau, which nobody makes");
    const openvdb::FloatGrid::ConstPtr grid = mContext.tau();
    const openvdb::CoordBBox known = grid->evalActiveVoxelBoundingBox();
    mTau.resize(mLattice.count());
    mLattice.forEachRow([&](int x, int y) {
      const openvdb::FloatGrid::ConstAccessor accessor = grid->getConstAccessor();
      for (int z = 0; z < mLattice.size[2]; ++z) {
        Vec3d at = grid->worldToIndex(mLattice.world(Vec3d(x, y, z)));
        for (int axis = 0; axis < 3; ++axis)
          at[axis] = std::clamp<double>(at[axis], known.min()[axis], known.max()[axis]);
        mTau[mLattice.index(x, y, z)] = static_cast<float>(openvdb::tools::BoxSampler::sample(accessor, at) / mLongest);
      }
    });
    return mTau;
  }

 private:
  template <class Body>
  void forEachNode(const Body& body) const {
    mLattice.forEachRow([&](int x, int y) {
      for (int z = 0; z < mLattice.size[2]; ++z) body(Coord(x, y, z), mLattice.index(x, y, z));
    });
  }

  /// The derivative of @a values along an axis, per longest side of the target, by central differences.
  double slope(const Values& values, const Coord& node, int axis) const {
    Coord before = node, behind = node;
    before[axis] = std::max(node[axis] - 1, 0);
    behind[axis] = std::min(node[axis] + 1, mLattice.size[axis] - 1);
    const double rise = values[mLattice.index(behind[0], behind[1], behind[2])] -
                        values[mLattice.index(before[0], before[1], before[2])];
    return rise / ((behind[axis] - before[axis]) * mLattice.voxel / mLongest);
  }

  const ControlLattice& mLattice;
  const ControlContext& mContext;
  double mLongest;  ///< world units
  Values mPhi, mCurvature, mTau;
  std::array<Values, 3> mNormals;
};

/// The value of a variable at a node.
using Variable = std::function<double(const Coord& node, std::size_t index)>;

class ExpressionSource final : public ControlSource {
 public:
  ExpressionSource(std::string expression, std::vector<std::string> names, std::string option)
      : mExpression(std::move(expression)), mNames(std::move(names)), mOption(std::move(option)) {}
  std::string text() const override { return "expr:" + mExpression; }
  bool needsTarget() const override { return true; }

  Control bind(const ControlContext& context) const override {
    if (!context.phi) throw std::logic_error("an expression is bound to a target without distances");
    const ControlLattice lattice = controlLattice(context);
    Surroundings surroundings(lattice, context);
    const std::vector<Values> painted = attributesOf(lattice, context);
    std::vector<Variable> variables;
    std::size_t attribute = 0;
    for (const std::string& name : mNames) {
      Variable variable = variableOf(name, lattice, context, surroundings);
      if (!variable) {
        const Values& values = painted[attribute++];
        variable = [&values](const Coord&, std::size_t index) { return double{values[index]}; };
      }
      variables.push_back(std::move(variable));
    }
    Values values(lattice.count());
    tbb::enumerable_thread_specific<julia::Expression> expressions(
        [this] { return julia::Expression(mExpression, mNames); });
    lattice.forEachRow([&](int x, int y) {
      julia::Expression& expression = expressions.local();
      std::vector<double> at(variables.size());
      for (int z = 0; z < lattice.size[2]; ++z) {
        const std::size_t index = lattice.index(x, y, z);
        for (std::size_t v = 0; v < variables.size(); ++v) at[v] = variables[v](Coord(x, y, z), index);
        values[index] = static_cast<float>(expression.at(at));
      }
    });
    requireFinite(values, variables, lattice);
    smooth(lattice, values);
    return Control(latticeField(lattice, std::move(values)));
  }

 private:
  /// Empty if the name is not one of kVariables.
  static Variable variableOf(const std::string& name, const ControlLattice& lattice, const ControlContext& context,
                             Surroundings& surroundings) {
    const auto stored = [](const Values& values) -> Variable {
      return [&values](const Coord&, std::size_t index) { return double{values[index]}; };
    };
    if (name == "phi") return stored(surroundings.phi());
    if (name == "tau") return stored(surroundings.tau());
    if (name == "curvature") return stored(surroundings.curvature());
    const std::string letters = name == "height" ? "hy" : name;
    const int axis = letters.empty() || letters.back() < 'x' || letters.back() > 'z' ? -1 : letters.back() - 'x';
    if (axis < 0 || letters.size() > 2) return nullptr;
    if (letters.size() == 1)
      return [&lattice, &context, axis](const Coord& node, std::size_t) {
        return context.space.toFractal(lattice.first[axis] + lattice.voxel * node[axis], axis);
      };
    if (letters[0] == 'n') return stored(surroundings.normal(axis));
    if (letters[0] != 'h') return nullptr;
    return [&lattice, &context, axis](const Coord& node, std::size_t) {
      const double side = context.targetBox.extents()[axis];
      const double at = lattice.first[axis] + lattice.voxel * node[axis] - context.targetBox.min()[axis];
      return side > 0 ? std::clamp(at / side, 0.0, 1.0) : 0.0;
    };
  }

  /// The attributes for the names that are not variables, in their order.
  std::vector<Values> attributesOf(const ControlLattice& lattice, const ControlContext& context) const {
    std::vector<const VertexAttribute*> attributes;
    for (const std::string& name : mNames) {
      if (isExpressionVariable(name)) continue;
      const Mesh* mesh = context.mesh.get();
      const bool isThere =
          mesh && std::any_of(mesh->attributes.begin(), mesh->attributes.end(),
                              [&name](const VertexAttribute& attribute) { return attribute.name == name; });
      if (!isThere)
        throw DataError("the expression '" + mExpression + "' of --" + mOption + " refers to '" + name +
                        "', which is neither a variable (" + kVariables + ") nor a vertex attribute of the target" +
                        (mesh ? " (it has " + attributeNames(*mesh) + ")" : ", which is a VDB"));
      attributes.push_back(&requireAttribute(*mesh, name, "the target's mesh"));
    }
    return attributes.empty() ? std::vector<Values>() : extended(lattice, *context.mesh, attributes);
  }

  void requireFinite(const Values& values, const std::vector<Variable>& variables,
                     const ControlLattice& lattice) const {
    for (int x = 0; x < lattice.size[0]; ++x)
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int z = 0; z < lattice.size[2]; ++z) {
          const std::size_t index = lattice.index(x, y, z);
          if (std::isfinite(values[index])) continue;
          std::string where;
          for (std::size_t v = 0; v < variables.size(); ++v)
            where +=
                (v == 0 ? " where " : ", ") + mNames[v] + " = " + numbersText({variables[v](Coord(x, y, z), index)});
          throw DataError("the expression '" + mExpression + "' of --" + mOption + " is " +
                          std::to_string(values[index]) + where +
                          "; it must have a finite value everywhere in the target's box and a tenth around it");
        }
  }

  std::string mExpression;
  std::vector<std::string> mNames;  ///< the names to which it refers
  std::string mOption;              ///< for errors
};

}  // namespace

bool isExpressionVariable(const std::string& name) {
  return (", " + std::string(kVariables) + ",").find(", " + name + ",") != std::string::npos;
}

ControlSourcePtr expressionSource(const std::string& expression, const std::string& option) {
  return std::make_shared<ExpressionSource>(expression, julia::namesInExpression(expression), option);
}

ControlSourcePtr parseExpressionControl(const RecipeReader& reader, const std::string& option) {
  const std::optional<std::string> expression = afterPrefix(reader.text(option), "expr:");
  if (!expression) return nullptr;
  try {
    return expressionSource(*expression, option);
  } catch (const std::invalid_argument& error) {
    reader.refuse(option, "an expression that can be read; in what follows expr:, " + std::string(error.what()));
  }
}

}  // namespace vdbtools
