// SPDX-License-Identifier: Apache-2.0
/// @file point_attributes.h
/// The attributes of a scene at any points: for the vertices of its mesh on their way to a sink, and for the voxels of
/// its grids.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/scene/scene.h"

#include <memory>
#include <span>
#include <vector>

namespace vdbtools {

class PointAttributes {
 public:
  /// @param scene   must outlive this
  /// @param origin  of the points' coordinates, world units, as in FieldPlan::origin
  /// @throw as sceneColouring()
  explicit PointAttributes(const Scene& scene, const openvdb::Vec3d& origin = openvdb::Vec3d(0));
  ~PointAttributes();

  /// The columns of meshColumns().
  const std::vector<VertexColumn>& columns() const { return mColumns; }
  std::size_t rowLength() const { return mRowLength; }
  /// The velocities of points, world units from the origin.
  std::vector<openvdb::Vec3d> velocities(std::span<const openvdb::Vec3d> points) const;
  /// How far a velocity goes in a frame, world units.
  openvdb::Vec3d wayInFrame(const openvdb::Vec3d& velocity) const { return velocity * mScene.velocity->frame(); }

  /// Sets a row for each point, world units from the origin. A row depends on its point alone. Many threads may call it
  /// at once.
  void evaluate(std::span<const openvdb::Vec3d> points, std::span<float> rows) const;

  /// The same in threads. @throw Interrupted
  void evaluate(std::span<const openvdb::Vec3d> points, std::span<float> rows, const Monitor& monitor) const;

 private:
  struct Batch;
  struct Column;
  struct Transfer;

  const Scene& mScene;
  openvdb::Vec3d mOrigin;
  std::vector<VertexColumn> mColumns;
  std::size_t mRowLength;
  std::vector<std::unique_ptr<const Column>> mFillers;  ///< one for each column
  std::unique_ptr<const Transfer> mTransfer;            ///< if attributes are transferred
  bool mNeedsIterations = false;
  bool mNeedsRest = false;
};

/// Gives each point its row on the way to another sink.
class AttributedSink final : public MeshSink {
 public:
  /// All of them must outlive this.
  AttributedSink(const PointAttributes& attributes, MeshSink& next, const Monitor& monitor)
      : mAttributes(attributes), mNext(next), mMonitor(monitor) {}

  /// @throw Interrupted, and what the next sink throws
  void addPoints(const PointBatch& batch) override;
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override {
    mNext.addTriangles(triangles, firstPoint);
  }

 private:
  const PointAttributes& mAttributes;
  MeshSink& mNext;
  const Monitor& mMonitor;
  std::vector<float> mRows;
};

/// The attributes as grids of the columns' names over the active voxels of @a surface: colours (of the vector type
/// invariant) and vectors as Vec3SGrid (world vectors of the type contravariant relative), numbers as FloatGrid.
/// Texture coordinates have no grid. Velocities go beyond these voxels, as far as the surface moves in a frame: a
/// renderer looks for the velocity at the place to which something moves. There they are tiles of 8^3 voxels.
/// @throw Interrupted
std::vector<openvdb::GridBase::Ptr> attributeGrids(const PointAttributes& attributes, const openvdb::FloatGrid& surface,
                                                   Monitor& monitor);

}  // namespace vdbtools
