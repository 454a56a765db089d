// SPDX-License-Identifier: Apache-2.0
#include "job/point_attributes.h"

#include "base/in_parallel.h"
#include "base/srgb.h"
#include "control/control_lattice.h"
#include "scene/scene_colouring.h"
#include "search/surface_search.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/control/control.h"

#include <openvdb/tools/Morphology.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;
using openvdb::FloatTree;
using openvdb::Vec3d;
using openvdb::Vec3s;
using openvdb::Vec3SGrid;
using openvdb::Vec3STree;

/// The position of a column in the rows of a batch.
struct Cells {
  float* first;        ///< in the first row
  std::size_t stride;  ///< floats from row to row

  float* operator[](std::size_t row) const { return first + row * stride; }
};

template <class Vector>
void putVectors(const std::vector<Vector>& values, const Cells& cells) {
  for (std::size_t i = 0; i < values.size(); ++i)
    for (int k = 0; k < 3; ++k) cells[i][k] = static_cast<float>(values[i][k]);
}

void putNumbers(std::span<const double> values, const Cells& cells) {
  for (std::size_t i = 0; i < values.size(); ++i) *cells[i] = static_cast<float>(values[i]);
}

}  // namespace

/// A batch of points, and the values that several columns need.
struct PointAttributes::Batch {
  std::span<const Vec3d> world;
  std::vector<Vec3d> atRest{};           ///< the same at rest, if a column needs that
  std::vector<julia::Point> points{};    ///< fractal space
  std::vector<double> iterations{};      ///< if a column needs them
  std::vector<SurfacePoint> onTarget{};  ///< the target's nearest points, if anything is transferred
};

struct PointAttributes::Column {
  std::size_t offset;  ///< in a row
  std::function<void(const Batch&, const Cells&)> fill;
};

/// The target's surface. It is searched in units of a hundredth of its longest side, relative to its middle.
struct PointAttributes::Transfer {
  static constexpr double kLength = 100;

  explicit Transfer(const Mesh& target)
      : mesh(target), box(boxOf(target)), scale(kLength / longestSide(box)), search(scaled(target), target.triangles) {}

  static openvdb::BBoxd boxOf(const Mesh& target) {
    openvdb::BBoxd box;
    for (const openvdb::Vec3I& triangle : target.triangles)
      for (int k = 0; k < 3; ++k) box.expand(target.points[triangle[k]]);
    return box;
  }
  Vec3d toSearch(const Vec3d& world) const { return (world - box.getCenter()) * scale; }
  std::vector<Vec3d> scaled(const Mesh& target) const {
    std::vector<Vec3d> points;
    points.reserve(target.points.size());
    for (const Vec3d& point : target.points) points.push_back(toSearch(point));
    return points;
  }
  std::vector<SurfacePoint> nearest(std::span<const Vec3d> world) const {
    std::vector<SurfacePoint> result;
    result.reserve(world.size());
    for (const Vec3d& point : world) {
      const std::optional<SurfacePoint> found = search.nearest(toSearch(point));
      if (!found) throw DataError("the target's mesh has no triangle with an area; check the file");
      result.push_back(*found);
    }
    return result;
  }

  double attributeAt(const SurfacePoint& point, const VertexAttribute& attribute) const {
    const openvdb::Vec3I& triangle = mesh.triangles[point.triangle];
    return interpolated(point.weights, [&](int k) { return double{attribute.values[triangle[k]]}; });
  }
  double coordinateAt(const SurfacePoint& point, int component) const {
    const openvdb::Vec2s* corners = &mesh.cornerUvs[3 * std::size_t{point.triangle}];
    return interpolated(point.weights, [&](int k) { return double{corners[k][component]}; });
  }
  const VertexAttribute& attribute(const std::string& name) const {
    return requireAttribute(mesh, name, "the target's mesh");
  }

  const Mesh& mesh;
  openvdb::BBoxd box;  ///< world units
  double scale;
  SurfaceSearch search;
};

PointAttributes::~PointAttributes() = default;

PointAttributes::PointAttributes(const Scene& scene, const Vec3d& origin)
    : mScene(scene),
      mOrigin(origin),
      mColumns(meshColumns(scene.options.output.attributes)),
      mRowLength(vdbtools::rowLength(mColumns)) {
  const AttributeOptions& options = scene.options.output.attributes;
  const julia::FieldEvaluator& evaluator = *scene.field.evaluator;
  const julia::DropAxis dropAxis = scene.options.map->embedding().dropped;
  std::size_t offset = 0;
  const auto add = [&](std::function<void(const Batch&, const Cells&)> fill) {
    offset = mFillers.empty() ? 0 : offset + componentsOf(mColumns[mFillers.size() - 1].kind);
    mFillers.push_back(std::make_unique<Column>(Column{offset, std::move(fill)}));
  };
  const auto addControl = [&](const Control& control, bool isAtRest = false) {
    mNeedsRest |= isAtRest;
    add([control, isAtRest](const Batch& batch, const Cells& cells) {
      std::vector<double> values(batch.world.size());
      control.sample(isAtRest ? std::span<const Vec3d>(batch.atRest) : batch.world, values);
      putNumbers(values, cells);
    });
  };
  for (const PointAttribute attribute : options.computed) switch (attribute) {
      case PointAttribute::Cd: {
        const FieldColouring colouring = sceneColouring(scene, options.colour.value_or(ColourChoice{}));
        mNeedsIterations |= colouring.by == FieldColour::Iterations;
        const ColourContext context{.maxIterations = scene.field.orbit.maxIterations, .dropAxis = dropAxis};
        add([&evaluator, colouring, context](const Batch& batch, const Cells& cells) {
          putVectors(fieldColours(colouring, evaluator, context, batch.points, batch.iterations), cells);
        });
        break;
      }
      case PointAttribute::Direction:
        add([&evaluator, dropAxis](const Batch& batch, const Cells& cells) {
          putVectors(firstDirections(evaluator, dropAxis, batch.points), cells);
        });
        break;
      case PointAttribute::Trap:
        add([&evaluator](const Batch& batch, const Cells& cells) {
          putNumbers(trapRadii(evaluator, batch.points), cells);
        });
        break;
      case PointAttribute::Iterations:
        mNeedsIterations = true;
        add([](const Batch& batch, const Cells& cells) { putNumbers(batch.iterations, cells); });
        break;
      case PointAttribute::Depth: addControl(distanceControl(scene.target.value().distances)); break;
      case PointAttribute::Tau: addControl(clampedControl(scene.target->thickness), true); break;
      case PointAttribute::Mask: addControl(scene.shellOptions().mask, true); break;
      case PointAttribute::Velocity:
        if (!scene.velocity) throw std::logic_error("velocities are wanted of a scene that has none");
        add([&velocity = *scene.velocity](const Batch& batch, const Cells& cells) {
          putVectors(velocity.at(batch.world), cells);
        });
        break;
    }
  if (options.transferred.empty()) return;
  if (!scene.target->mesh) throw std::logic_error("attributes are transferred from a mesh that is not there");
  mTransfer = std::make_unique<Transfer>(*scene.target->mesh);
  const Transfer& from = *mTransfer;
  for (const std::string& name : options.transferred) {
    if (name == "uv") {
      add([&from](const Batch& batch, const Cells& cells) {
        for (std::size_t i = 0; i < batch.onTarget.size(); ++i)
          for (int k = 0; k < 2; ++k) cells[i][k] = static_cast<float>(from.coordinateAt(batch.onTarget[i], k));
      });
    } else if (name == "Cd") {
      const std::array<const VertexAttribute*, 3> channels = {&from.attribute("red"), &from.attribute("green"),
                                                              &from.attribute("blue")};
      add([&from, channels](const Batch& batch, const Cells& cells) {
        for (std::size_t i = 0; i < batch.onTarget.size(); ++i)
          for (std::size_t k = 0; k < 3; ++k)
            cells[i][k] = static_cast<float>(
                linearFromSrgb(std::clamp(from.attributeAt(batch.onTarget[i], *channels[k]), 0.0, 1.0)));
      });
    } else {
      add([&from, &attribute = from.attribute(name)](const Batch& batch, const Cells& cells) {
        for (std::size_t i = 0; i < batch.onTarget.size(); ++i)
          *cells[i] = static_cast<float>(from.attributeAt(batch.onTarget[i], attribute));
      });
    }
  }
}

std::vector<Vec3d> PointAttributes::velocities(std::span<const Vec3d> points) const {
  std::vector<Vec3d> moved(points.begin(), points.end());
  for (Vec3d& point : moved) point += mOrigin;
  return mScene.velocity->at(moved);
}

void PointAttributes::evaluate(std::span<const Vec3d> points, std::span<float> rows) const {
  if (points.empty()) return;
  std::vector<Vec3d> moved;
  if (mOrigin != Vec3d(0)) {
    moved.assign(points.begin(), points.end());
    for (Vec3d& point : moved) point += mOrigin;
    points = moved;
  }
  Batch batch{.world = points};
  batch.points.reserve(points.size());
  for (const Vec3d& point : points) batch.points.push_back(mScene.field.space.toFractal(point));
  if (mNeedsIterations)
    batch.iterations =
        meanIterations(*mScene.field.evaluator, batch.points, mScene.voxelSize / mScene.field.space.scale);
  if (mNeedsRest) batch.atRest = mScene.atRest(points);
  if (mTransfer) batch.onTarget = mTransfer->nearest(points);
  for (const auto& column : mFillers) column->fill(batch, {rows.data() + column->offset, mRowLength});
}

void PointAttributes::evaluate(std::span<const Vec3d> points, std::span<float> rows, const Monitor& monitor) const {
  const std::size_t batch = mScene.field.evaluator->preferredBatch(), batches = (points.size() + batch - 1) / batch;
  inParallel(batches, 1, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end && !monitor.cancelled(); ++i) {
      const std::size_t first = i * batch, count = std::min(batch, points.size() - first);
      evaluate(points.subspan(first, count), rows.subspan(first * mRowLength, count * mRowLength));
    }
  });
}

void AttributedSink::addPoints(const PointBatch& batch) {
  mRows.resize(batch.positions.size() * mAttributes.rowLength());
  mAttributes.evaluate(batch.positions, mRows, mMonitor);
  mNext.addPoints({batch.positions, batch.normals, mRows});
}

namespace {

template <class Tree>
struct Part {
  typename Tree::Ptr tree;
  std::unique_ptr<openvdb::tree::LeafManager<Tree>> leaves;

  explicit Part(const FloatTree& topology)
      : tree(std::make_shared<Tree>(topology, typename Tree::ValueType(0), openvdb::TopologyCopy())),
        leaves(std::make_unique<openvdb::tree::LeafManager<Tree>>(*tree)) {}
};

/// A grid that is being filled.
struct AttributeGrid {
  std::size_t offset;  ///< in a row
  std::optional<Part<FloatTree>> numbers;
  std::optional<Part<Vec3STree>> vectors;
  bool reachesOn = false;  ///< whether it goes beyond the surface, as velocities do
};

using VectorLeaf = Vec3STree::LeafNodeType;

/// Sets the velocities of the voxels of a leaf that have none.
void fillVelocities(VectorLeaf& leaf, const PointAttributes& attributes, const FloatGrid& surface) {
  std::vector<Vec3d> points;
  for (auto value = leaf.cbeginValueOff(); value; ++value) points.push_back(surface.indexToWorld(value.getCoord()));
  const std::vector<Vec3d> velocities = attributes.velocities(points);
  std::size_t i = 0;
  for (openvdb::Index n = 0; n < VectorLeaf::SIZE; ++n)
    if (!leaf.isValueOn(n)) leaf.setValueOn(n, Vec3s(velocities[i++]));
}

/// Adds tiles of 8^3 voxels through which the surface moves in a frame before or after.
void addVelocityTiles(Vec3STree& tree, const PointAttributes& attributes, const FloatGrid& surface,
                      const Monitor& monitor) {
  constexpr int kSide = VectorLeaf::DIM;
  const openvdb::BBoxd box = surface.transform().indexToWorld(surface.evalActiveVoxelBoundingBox());
  const double side = kSide * surface.voxelSize()[0];
  const double farthest = 2 * longestSide(box);  // what moves farther in a frame is seen nowhere
  const auto blockOf = [&](const Vec3d& world) {
    return openvdb::Coord::floor(surface.worldToIndex(world) / static_cast<double>(kSide));
  };
  openvdb::MaskTree reached;  // a voxel stands for a block
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    const Vec3d middle = surface.indexToWorld(leaf->origin().asVec3d() + (kSide - 1) / 2.0);
    Vec3d way = attributes.wayInFrame(Vec3d(leaf->getValue(VectorLeaf::SIZE / 2)));
    if (const double length = way.length(); length > farthest) way *= farthest / length;
    const int steps = static_cast<int>(way.length() / side) + 1;
    for (int step = -steps; step <= steps; ++step) reached.setValueOn(blockOf(middle + way * step / steps));
  }
  openvdb::tools::dilateActiveValues(reached, 1, openvdb::tools::NN_FACE_EDGE_VERTEX);
  std::vector<openvdb::Coord> blocks;
  for (auto block = reached.cbeginValueOn(); block; ++block)
    for (const openvdb::Coord& at : block.getBoundingBox())
      if (const openvdb::Coord origin(at[0] * kSide, at[1] * kSide, at[2] * kSide); !tree.probeConstLeaf(origin))
        blocks.push_back(origin);
  std::vector<Vec3d> velocities(blocks.size());
  constexpr std::size_t kBatch = 256;
  inParallel((blocks.size() + kBatch - 1) / kBatch, 1, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t first = begin * kBatch; first < std::min(end * kBatch, blocks.size()); first += kBatch) {
      std::vector<Vec3d> points;
      for (std::size_t i = first; i < std::min(first + kBatch, blocks.size()); ++i)
        points.push_back(surface.indexToWorld(blocks[i].asVec3d() + (kSide - 1) / 2.0));
      const std::vector<Vec3d> found = attributes.velocities(points);
      std::copy(found.begin(), found.end(), velocities.begin() + static_cast<std::ptrdiff_t>(first));
    }
  });
  for (std::size_t i = 0; i < blocks.size(); ++i) tree.addTile(1, blocks[i], Vec3s(velocities[i]), true);
}

}  // namespace

std::vector<openvdb::GridBase::Ptr> attributeGrids(const PointAttributes& attributes, const FloatGrid& surface,
                                                   Monitor& monitor) {
  std::vector<AttributeGrid> parts;
  std::vector<openvdb::GridBase::Ptr> grids;
  std::size_t offset = 0;
  for (const VertexColumn& column : attributes.columns()) {
    AttributeGrid part{
        .offset = offset, .numbers = {}, .vectors = {}, .reachesOn = column.kind == ColumnKind::WorldVector};
    offset += componentsOf(column.kind);
    openvdb::GridBase::Ptr grid;
    if (column.kind == ColumnKind::Number) {
      part.numbers.emplace(surface.tree());
      grid = FloatGrid::create(part.numbers->tree);
    } else if (column.kind == ColumnKind::TextureCoordinate) {
      continue;
    } else {
      part.vectors.emplace(surface.tree());
      grid = Vec3SGrid::create(part.vectors->tree);
      if (column.kind == ColumnKind::LinearRgb) grid->setVectorType(openvdb::VEC_INVARIANT);
      if (column.kind == ColumnKind::WorldVector) grid->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
    }
    grid->setTransform(surface.transform().copy());
    grid->setName(column.name);
    grids.push_back(grid);
    parts.push_back(std::move(part));
  }
  if (parts.empty()) return grids;

  // All trees have the leaves of the surface, in its order.
  const openvdb::tree::LeafManager<const FloatTree> leaves(surface.tree());
  monitor.begin(PhaseKind::Attributes, leaves.leafCount());
  inParallel(leaves.leafCount(), 1, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3d> points;
    std::vector<float> rows;
    for (std::size_t n = begin; n < end && !monitor.cancelled(); ++n) {
      points.clear();
      for (auto value = leaves.leaf(n).cbeginValueOn(); value; ++value)
        points.push_back(surface.indexToWorld(value.getCoord()));
      rows.resize(points.size() * attributes.rowLength());
      attributes.evaluate(points, rows);
      for (const AttributeGrid& part : parts) {
        const float* row = rows.data() + part.offset;
        if (part.numbers)
          for (auto value = part.numbers->leaves->leaf(n).beginValueOn(); value; ++value, row += attributes.rowLength())
            value.setValue(*row);
        else
          for (auto value = part.vectors->leaves->leaf(n).beginValueOn(); value; ++value, row += attributes.rowLength())
            value.setValue(Vec3s(row[0], row[1], row[2]));
        if (part.reachesOn) fillVelocities(part.vectors->leaves->leaf(n), attributes, surface);
      }
      monitor.advance(1);
    }
  });
  monitor.throwIfCancelled();
  for (const AttributeGrid& part : parts)
    if (part.reachesOn) addVelocityTiles(*part.vectors->tree, attributes, surface, monitor);
  return grids;
}

}  // namespace vdbtools
