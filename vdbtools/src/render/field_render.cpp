// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/field_render.h"

#include "base/in_parallel.h"
#include "base/timed_part.h"
#include "render/field_shading.h"
#include "render/image_layers.h"
#include "render/neighbourhood.h"
#include "render/occupancy.h"
#include "render/ray_steps.h"
#include "render/shading.h"
#include "render/shadow_proxy.h"
#include "render/view.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Vec3d;

constexpr int kTile = 32;  ///< pixels along the side of a tile, whose rays one thread marches together
/// The maximum number of samples of one ray in a batch of points; samples after its hit are wasted.
constexpr std::size_t kMostAhead = 32;
constexpr int kBisections = 12;  ///< they locate the surface to 1/4096 of a step

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Vec3d inFractalSpace(const FractalSpace& space, const Vec3d& world) {
  const julia::Point x = space.toFractal(world);
  return {x[0], x[1], x[2]};
}

julia::Point pointOf(const Vec3d& x) { return {x[0], x[1], x[2]}; }

/// Cells along the region's longest side, for pictures with this many rays. Cells about eight rays wide are
/// approximately the finest that save more than they cost.
int occupancyCells(const FieldRenderOptions& options) {
  constexpr unsigned kRays = 8, kFewest = 64, kMost = 256;
  const auto across = std::max(options.width, options.height) * std::sqrt(options.samples);
  return static_cast<int>(std::clamp(std::bit_ceil(static_cast<unsigned>(across) / kRays), kFewest, kMost));
}

void requireOptions(const FieldRenderOptions& o) {
  constexpr double kShortestStep = 1e-9;
  PixelSamples(o.width, o.height, o.samples);
  frameOf(o.camera);
  if (o.clarity.alpha) {
    const double alpha = *o.clarity.alpha;
    requireOption(alpha >= 0 && std::isfinite(alpha), "alpha", alpha, "at least 0");
  }
  requireOption(o.clarity.delta >= 0 && o.clarity.delta <= 2, "delta", o.clarity.delta, "0, 1 or 2");
  requireOption(o.clarity.epsilon >= kShortestStep && std::isfinite(o.clarity.epsilon), "epsilon", o.clarity.epsilon,
                "at least 1e-9");
  julia::requireValid(o.orbit);
}

/// The lattices that cast the shadows in a picture.
ShadowProxy::Need shadowsFor(const FieldRenderOptions& options, const FractalSpace& space, const BBoxd& region) {
  constexpr int kPixels = 3, kFewest = 64, kMost = 256;  // pixels per voxel, if the whole region is visible
  constexpr double kAround = 1.25;                       // margin beyond the picture's edges
  const double distance = (options.camera.lookAt - options.camera.eye).length() / space.scale;
  const double aspect = static_cast<double>(options.width) / options.height;
  return {.region = region,
          .focus = inFractalSpace(space, options.camera.lookAt),
          .reach = kAround * distance * frameOf(options.camera).tangent * std::max(1.0, aspect),
          .cells = std::clamp(std::max(options.width, options.height) / kPixels, kFewest, kMost)};
}

/// The distance of x from a box; 0 inside.
double distanceTo(const BBoxd& box, const Vec3d& x) {
  Vec3d off;
  for (int axis = 0; axis < 3; ++axis)
    off[axis] = std::max({box.min()[axis] - x[axis], x[axis] - box.max()[axis], 0.0});
  return off.length();
}

struct Ray {
  Vec3d direction;
  std::uint32_t pixel = 0;  ///< in the tile
  int sample = 0;           ///< of the pixel
  double t = 0, end = 0;    ///< distances of the next sample and of the end of the region
  double before = 0;        ///< distance of the sample before the next one
  bool entering = true;     ///< whether there was no sample before
  int entryAxis = -1;       ///< axis of the face through which the ray enters the region; -1 if it starts inside
  Occupancy::Walker::Span known{true, 0};
};

struct Sample {
  double before, t;  ///< distances of the sample before this one and of this one
  bool first;        ///< whether it is the first of its ray
};

/// Where a ray met the set.
struct Meeting {
  Ray ray;
  double outside, inside;  ///< around the surface
  bool atEntry;
};

/// Clips the ray to the region. @return whether any part remains
bool enter(Ray& ray, const Vec3d& eye, const BBoxd& region) {
  double from = 0, to = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    const double d = ray.direction[axis];
    if (d == 0) {
      if (eye[axis] < region.min()[axis] || eye[axis] > region.max()[axis]) return false;
      continue;
    }
    double near = (region.min()[axis] - eye[axis]) / d, far = (region.max()[axis] - eye[axis]) / d;
    if (near > far) std::swap(near, far);
    if (near > from) {
      from = near;
      ray.entryAxis = axis;
    }
    to = std::min(to, far);
  }
  ray.t = from;
  ray.end = to;
  return from < to;
}

/// The rendering of one picture.
class Exposure {
 public:
  /// @param region     fractal space
  /// @param occupancy  if null, every sample is evaluated
  Exposure(const FieldSource& source, const BBoxd& region, const Occupancy* occupancy, const ShadowProxy& shadows,
           const FieldRenderOptions& options, Monitor& monitor)
      : mEvaluator(source.evaluator),
        mOptions(options),
        mMonitor(monitor),
        mScale(source.space.scale),
        mEye(inFractalSpace(source.space, options.camera.eye)),
        mRegion(region),
        mFrame(frameOf(options.camera)),
        mSteps(options.clarity, 2 * mFrame.tangent / options.height,
               (options.camera.lookAt - options.camera.eye).length() / mScale),
        mSamples(options.width, options.height, options.samples),
        mOccupancy(occupancy),
        mShadows(shadows) {
    mStage = previewStage(
        options.camera, options.look, options.camera.up.unit(), mSamples.aspect(),
        {source.space.toWorld(pointOf(mShadows.middle())), mShadows.radius() * mScale},
        [&](const Vec3d& world) { return inFractalSpace(source.space, world); },
        [](const Vec3d& direction) { return direction.unit(); });
    if (options.look.ground) mStage.floor = mShadows.lowestAlong(mStage.sky);
    const double farthest = (mRegion.getCenter() - mEye).length() + mRegion.extents().length();
    if (!mSteps.servesUpTo(farthest))
      throw std::invalid_argument(
          "render: epsilon is too small for an eye this far from the region; make it larger, or move the eye nearer");
    // The sequence starts slightly before the region, so that every position in the region is beyond its first member.
    constexpr double kBefore = 1 - 1e-9;
    mSteps.lay(kBefore * distanceTo(mRegion, mEye), farthest, monitor);
    if (mEvaluator.preferredRays() > 0) prepareMarch();
  }

  FieldImage render() {
    preview::Layers layers(mOptions.width, mOptions.height, mOptions.passes);
    mMonitor.begin(PhaseKind::Render, tileCount());
    if (mEvaluator.preferredRays() > 0) {
      // A device gets the rays of many tiles at a time.
      const auto together = std::max<std::size_t>(1, mEvaluator.preferredRays() / raysOfTile());
      std::vector<std::size_t> numbers;
      for (std::size_t tile = 0; tile < tileCount() && !mMonitor.cancelled();) {
        numbers.clear();
        while (numbers.size() < together && tile < tileCount()) numbers.push_back(tile++);
        renderTiles(numbers, layers);
        mMonitor.advance(numbers.size());
      }
      mMonitor.throwIfCancelled();
    } else {
      inParallel(tileCount(), 1, mMonitor, [&](std::size_t begin, std::size_t end) {
        for (std::size_t tile = begin; tile < end && !mMonitor.cancelled(); ++tile) {
          renderTiles({&tile, 1}, layers);
          mMonitor.advance(1);
        }
      });
    }
    FieldImage image;
    static_cast<ShadedImage&>(image) = layers.take();
    image.rays = mRays;
    image.evaluations = mEvaluations;
    return image;
  }

  /// Estimates the CPU seconds of render() from some tiles spread over the picture.
  double estimatedSeconds() {
    constexpr std::size_t kTimed = 16;
    const std::size_t count = tileCount(), timed = std::min(kTimed, count);
    preview::Layers layers(mOptions.width, mOptions.height, mOptions.passes);
    const double start = cpuSeconds();
    inParallel(timed, 1, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end && !mMonitor.cancelled(); ++i) {
        // About one tile from each row of tiles, in unrelated columns.
        const std::size_t low = i * count / timed, high = (i + 1) * count / timed;
        const double place = std::numbers::phi * static_cast<double>(i);
        const std::size_t tile =
            low + static_cast<std::size_t>((place - std::floor(place)) * static_cast<double>(high - low));
        renderTiles({&tile, 1}, layers);
      }
    });
    return (cpuSeconds() - start) * static_cast<double>(count) / static_cast<double>(timed);
  }

 private:
  struct Tile {
    int left, top, width, height;
  };

  /// A tile while it is rendered.
  struct TileWork {
    Tile tile;
    std::vector<preview::Pixel> pixels;  ///< row by row
    std::vector<std::uint32_t> chosen;   ///< the pixels that are sampled
    std::vector<Ray> rays;               ///< that have not ended
    std::vector<Meeting> meetings;
    std::size_t firstHit = 0;  ///< the number of its first hit among those of all tiles that are rendered together
  };

  static std::size_t tilesAlong(int side) { return static_cast<std::size_t>((side + kTile - 1) / kTile); }
  std::size_t tileCount() const { return tilesAlong(mOptions.width) * tilesAlong(mOptions.height); }

  std::size_t raysOfTile() const {
    return static_cast<std::size_t>(kTile) * kTile * static_cast<std::size_t>(mSamples.usual());
  }

  /// Calls work(tile) for each tile, in parallel if there are several.
  template <class Work>
  void each(std::span<TileWork> tiles, const Work& work) const {
    if (tiles.size() == 1) return work(tiles[0]);
    inParallel(tiles.size(), 1, mMonitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) work(tiles[i]);
    });
  }

  /// @param number  number of the tile, row by row
  Tile tileOf(std::size_t number) const {
    const int left = static_cast<int>(number % tilesAlong(mOptions.width)) * kTile;
    const int top = static_cast<int>(number / tilesAlong(mOptions.width)) * kTile;
    return {left, top, std::min(kTile, mOptions.width - left), std::min(kTile, mOptions.height - top)};
  }

  void renderTiles(std::span<const std::size_t> numbers, preview::Layers& layers) {
    std::vector<TileWork> tiles(numbers.size());
    for (std::size_t i = 0; i < tiles.size(); ++i) {
      tiles[i].tile = tileOf(numbers[i]);
      tiles[i].pixels.resize(std::size_t(tiles[i].tile.width) * std::size_t(tiles[i].tile.height));
      tiles[i].chosen.resize(tiles[i].pixels.size());
      std::iota(tiles[i].chosen.begin(), tiles[i].chosen.end(), 0U);
    }
    sample(tiles, 0, mSamples.usual());
    for (TileWork& work : tiles)
      std::erase_if(work.chosen, [&](std::uint32_t pixel) { return !work.pixels[pixel].isRough(); });
    const auto isSmooth = [](const TileWork& work) { return work.chosen.empty(); };
    if (!std::all_of(tiles.begin(), tiles.end(), isSmooth)) sample(tiles, mSamples.usual(), 2 * mSamples.usual());
    for (const TileWork& work : tiles) {
      const Tile& tile = work.tile;
      for (std::size_t i = 0; i < work.pixels.size(); ++i) {
        const auto at = (std::size_t(tile.top) + i / std::size_t(tile.width)) * std::size_t(mOptions.width) +
                        std::size_t(tile.left) + i % std::size_t(tile.width);
        layers.set(at, work.pixels[i].shown(), mFrame.forward.dot(work.pixels[i].direction()) * mScale,
                   openvdb::Mat3d::identity());
      }
    }
  }

  /// Adds the samples from @a begin to @a end to the chosen pixels of tiles.
  void sample(std::span<TileWork> tiles, int begin, int end) {
    each(tiles, [&](TileWork& work) {
      mRays += work.chosen.size() * static_cast<std::uint64_t>(end - begin);
      work.rays = raysOf(work.tile, work.chosen, begin, end);
      work.meetings.clear();
    });
    if (mEvaluator.preferredRays() > 0) follow(tiles);
    each(tiles, [&](TileWork& work) {
      std::vector<Meeting> meetings = march(std::move(work.rays));
      bisect(meetings);
      meetings.insert(meetings.end(), work.meetings.begin(), work.meetings.end());
      // The order of the meetings depends on when their rays ended, and the rounding of a sum depends on the order.
      std::sort(meetings.begin(), meetings.end(), [](const Meeting& a, const Meeting& b) {
        return std::tie(a.ray.pixel, a.ray.sample) < std::tie(b.ray.pixel, b.ray.sample);
      });
      work.meetings = std::move(meetings);
    });
    std::vector<FieldHit> hits;
    for (TileWork& work : tiles) {
      work.firstHit = hits.size();
      addHits(work.meetings, hits);
    }
    const FieldAround around = fieldAround(mEvaluator, hits);
    each(tiles, [&](TileWork& work) { shade(work, hits, around, begin, end); });
  }

  /// Has a device follow the rays of tiles, as march() and bisect() do it. Those that it leaves remain.
  void follow(std::span<TileWork> tiles) {
    std::vector<julia::MarchedRay> rays;
    for (const TileWork& work : tiles)
      for (const Ray& ray : work.rays)
        rays.push_back({pointOf(ray.direction), ray.entering ? ray.t : ray.before, ray.t, ray.end});
    std::vector<julia::RayMeeting> met(rays.size());
    mEvaluator.followRays(mMarch, rays, met);
    std::size_t number = 0;
    std::uint64_t evaluations = 0;
    for (TileWork& work : tiles) {
      std::size_t kept = 0;
      for (Ray& ray : work.rays) {
        const julia::RayMeeting& meeting = met[number++];
        evaluations += static_cast<std::uint64_t>(meeting.samples);
        if (meeting.end == julia::RayEnd::Met)
          work.meetings.push_back({ray, meeting.outside, meeting.inside, meeting.outside == meeting.inside});
        if (meeting.end != julia::RayEnd::Left) continue;
        ray.entering = meeting.outside == meeting.inside;
        ray.before = meeting.outside;
        ray.t = meeting.inside;
        work.rays[kept++] = ray;
      }
      work.rays.resize(kept);
    }
    mEvaluations += evaluations;
  }

  /// Describes the rays of the picture for a device.
  void prepareMarch() {
    mMarch = {.eye = pointOf(mEye),
              .alpha = mSteps.alpha(),
              .epsilon = mSteps.epsilon(),
              .delta = mSteps.delta(),
              .members = mSteps.members(),
              .bisections = kBisections};
    if (!mOccupancy) return;
    mOccupied = mOccupancy->bits();
    mMarch.occupied = mOccupied;
    for (int axis = 0; axis < 3; ++axis) mMarch.count[static_cast<std::size_t>(axis)] = mOccupancy->count()[axis];
    mMarch.corner = pointOf(mOccupancy->origin());
    mMarch.side = mOccupancy->cell();
  }

  void addHits(const std::vector<Meeting>& meetings, std::vector<FieldHit>& hits) const {
    hits.reserve(hits.size() + meetings.size());
    for (const Meeting& m : meetings) {
      FieldHit hit{mEye + m.inside * m.ray.direction, m.ray.direction, mSteps.length(m.inside), std::nullopt};
      if (m.atEntry) {
        Vec3d face(0);
        if (m.ray.entryAxis >= 0)
          face[m.ray.entryAxis] = m.ray.direction[m.ray.entryAxis] > 0 ? -1 : 1;
        else
          face = -m.ray.direction;
        hit.normal = face;
      }
      hits.push_back(hit);
    }
  }

  /// Adds to the pixels of a tile what its rays met.
  void shade(TileWork& work, std::span<const FieldHit> allHits, const FieldAround& around, int begin, int end) const {
    const Tile& tile = work.tile;
    std::vector<preview::Pixel>& pixels = work.pixels;
    const std::vector<Meeting>& meetings = work.meetings;
    const std::span<const FieldHit> hits = allHits.subspan(work.firstHit, meetings.size());
    const std::size_t first = kNeighbours * work.firstHit, count = kNeighbours * hits.size();
    const std::vector<FieldPoint> points =
        fieldPoints(mEvaluator, mOptions, hits, std::span(around.field).subspan(first, count),
                    std::span(around.iterations).subspan(first, count));
    preview::Shader<ShadowProxy::Surface> shader(ShadowProxy::Surface(mShadows), mStage, mOptions.look,
                                                 mOptions.samples);
    const std::vector<double> traps = trapsAt(hits);
    std::size_t next = 0;
    for (const std::uint32_t at : work.chosen) {
      const int x = tile.left + int(at) % tile.width, y = tile.top + int(at) / tile.width;
      const preview::PixelSequence sequence(x, y);
      for (int s = begin; s < end; ++s) {
        if (next < meetings.size() && meetings[next].ray.pixel == at && meetings[next].ray.sample == s) {
          const FieldHit& hit = hits[next];
          const FieldPoint& point = points[next];
          preview::Shown seen =
              shader.shade({meetings[next].inside, shader.surface().leave(hit.inside, hit.view, point.normal),
                            point.normal, point.albedo},
                           hit.view, sequence, s, pixels[at].key);
          if (!traps.empty()) seen.trap = traps[next];
          pixels[at].add(seen, hit.view);
          ++next;
        } else {
          const auto [u, v] = mSamples.at(x, y, s);
          const Vec3d direction = directionAt(u, v);
          pixels[at].add(shader.behind(direction, u, v, sequence, s), direction);
        }
      }
    }
  }

  std::vector<Ray> raysOf(const Tile& tile, const std::vector<std::uint32_t>& chosen, int begin, int end) const {
    std::vector<Ray> rays;
    rays.reserve(chosen.size() * std::size_t(end - begin));
    for (const std::uint32_t at : chosen) {
      for (int s = begin; s < end; ++s) {
        const auto [u, v] = mSamples.at(tile.left + int(at) % tile.width, tile.top + int(at) / tile.width, s);
        Ray ray;
        ray.direction = directionAt(u, v);
        ray.pixel = at;
        ray.sample = s;
        if (enter(ray, mEye, mRegion)) rays.push_back(ray);
      }
    }
    return rays;
  }

  /// Skips the samples that are known to be outside. @return whether there is a sample to evaluate
  bool toNextSample(Ray& ray, std::optional<Occupancy::Walker>& walker) const {
    if (!walker) return ray.t <= ray.end;
    while (ray.t <= ray.end) {
      double place = ray.t;
      for (;;) {
        if (place >= ray.known.end) ray.known = walker->at(mEye, ray.direction, place);
        if (ray.known.occupied) break;
        place = ray.known.end;
        if (place > ray.end) return false;
      }
      if (place == ray.t) return true;
      pass(ray, place);
    }
    return false;
  }

  /// Advances to the first sample at or after @a place.
  /// @param place  greater than ray.t
  void pass(Ray& ray, double place) const {
    const RaySteps::Reached reached = mSteps.reach(place);
    // The entry point of the ray is a sample, too.
    ray.before = std::max(reached.before, ray.t);
    ray.t = reached.t;
    ray.entering = false;
  }

  void step(Ray& ray) const {
    if (ray.entering) return pass(ray, std::nextafter(ray.t, kInfinity));
    ray.before = ray.t;
    ray.t = mSteps.next(ray.t);
  }

  /// Marches all rays together, so that the evaluator gets many points at a time. The samples of a ray do not depend on
  /// the other rays.
  std::vector<Meeting> march(std::vector<Ray> rays) {
    std::vector<Meeting> meetings;
    std::optional<Occupancy::Walker> walker;
    if (mOccupancy) walker.emplace(*mOccupancy);
    std::vector<julia::Point> points;
    std::vector<Sample> samples;
    std::vector<double> field;
    std::vector<std::size_t> ends;
    std::uint64_t evaluations = 0;
    while (!rays.empty() && !mMonitor.cancelled()) {
      const std::size_t ahead = std::clamp(mEvaluator.preferredBatch() / rays.size(), std::size_t(1), kMostAhead);
      points.clear();
      samples.clear();
      ends.clear();
      for (Ray& ray : rays) {
        for (std::size_t n = 0; n < ahead && toNextSample(ray, walker); ++n) {
          points.push_back(pointOf(mEye + ray.t * ray.direction));
          samples.push_back({ray.before, ray.t, ray.entering});
          step(ray);
        }
        ends.push_back(points.size());
      }
      field.resize(points.size());
      mEvaluator.evaluate(points, field, {});
      evaluations += points.size();
      std::size_t kept = 0, sample = 0;
      for (std::size_t i = 0; i < rays.size(); ++i) {
        const std::size_t begin = sample;
        while (sample < ends[i] && !(field[sample] < 0)) ++sample;
        if (sample < ends[i])
          meetings.push_back({rays[i], samples[sample].before, samples[sample].t, samples[sample].first});
        else if (sample - begin == ahead)
          rays[kept++] = rays[i];
        sample = ends[i];
      }
      rays.resize(kept);
    }
    mEvaluations += evaluations;
    return meetings;
  }

  void bisect(std::vector<Meeting>& meetings) const {
    std::vector<julia::Point> points(meetings.size());
    std::vector<double> field(meetings.size());
    const auto middle = [](const Meeting& m) { return m.atEntry ? m.inside : 0.5 * (m.outside + m.inside); };
    for (int step = 0; step < kBisections; ++step) {
      for (std::size_t i = 0; i < meetings.size(); ++i)
        points[i] = pointOf(mEye + middle(meetings[i]) * meetings[i].ray.direction);
      mEvaluator.evaluate(points, field, {});
      for (std::size_t i = 0; i < meetings.size(); ++i)
        (field[i] < 0 ? meetings[i].inside : meetings[i].outside) = middle(meetings[i]);
    }
  }

  /// Empty unless requested.
  std::vector<double> trapsAt(std::span<const FieldHit> hits) const {
    if (!mOptions.passes.contains(Pass::Trap)) return {};
    std::vector<julia::Point> points;
    for (const FieldHit& hit : hits) points.push_back(pointOf(hit.inside));
    return trapRadii(mEvaluator, points);
  }

  Vec3d directionAt(double u, double v) const {
    return (mFrame.forward + mFrame.tangent * (u * mSamples.aspect() * mFrame.right + v * mFrame.up)).unit();
  }

  const julia::FieldEvaluator& mEvaluator;
  const FieldRenderOptions& mOptions;
  Monitor& mMonitor;
  double mScale;  ///< world units per unit of fractal space
  Vec3d mEye;     ///< fractal space
  BBoxd mRegion;  ///< fractal space
  CameraFrame mFrame;
  RaySteps mSteps;
  PixelSamples mSamples;
  const Occupancy* mOccupancy;
  const ShadowProxy& mShadows;
  PreviewStage mStage{};     ///< fractal space
  julia::RayMarch mMarch{};  ///< set if a device follows the rays
  std::vector<std::uint32_t> mOccupied{};
  std::atomic<std::uint64_t> mRays{0}, mEvaluations{0};
};

}  // namespace

FramedBall frameSet(const FieldSource& source, const BBoxd& region) {
  constexpr int kFrameCells = 64;  // of the lattice, along the longest side of the region
  const Vec3d sides = region.extents();
  const double longest = std::max({sides[0], sides[1], sides[2]});
  const double cell = longest / kFrameCells;
  std::vector<julia::Point> points;
  std::vector<Vec3d> places;
  std::array<int, 3> count{};
  for (int axis = 0; axis < 3; ++axis)
    count[static_cast<std::size_t>(axis)] = std::max(1, static_cast<int>(std::ceil(sides[axis] / cell)));
  for (int i = 0; i < count[0]; ++i)
    for (int j = 0; j < count[1]; ++j)
      for (int k = 0; k < count[2]; ++k) {
        places.push_back(region.min() + cell * Vec3d(i + 0.5, j + 0.5, k + 0.5));
        points.push_back(source.space.toFractal(places.back()));
      }
  std::vector<double> field(points.size());
  source.evaluator.evaluate(points, field, {});
  BBoxd box;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (field[i] < 0) box.expand(places[i]);
  if (box.empty()) return {region.getCenter(), 0.5 * region.extents().length()};
  FramedBall ball{box.getCenter(), 0};
  for (std::size_t i = 0; i < places.size(); ++i)
    if (field[i] < 0) ball.radius = std::max(ball.radius, (places[i] - ball.centre).length());
  ball.radius += cell;
  return ball;
}

FieldRenderer::FieldRenderer(const FieldSource& source, const BBoxd& region)
    : mSource(source), mRegion(inFractalSpace(source.space, region.min()), inFractalSpace(source.space, region.max())) {
  for (int axis = 0; axis < 3; ++axis)
    requireOption(region.max()[axis] > region.min()[axis] && std::isfinite(region.extents()[axis]),
                  "a side of the region", region.extents()[axis], "above 0");
}

FieldRenderer::~FieldRenderer() = default;

void FieldRenderer::prepare(const FieldRenderOptions& options, Monitor& monitor) {
  requireOptions(options);
  monitor.throwIfCancelled();
  if (options.skip && !mOccupancy)
    mOccupancy = std::make_unique<const Occupancy>(mSource.evaluator, mRegion, occupancyCells(options), monitor);
  const ShadowProxy::Need need = shadowsFor(options, mSource.space, mRegion);
  if (!mShadows || !(mShadows->need() == need))
    mShadows = std::make_unique<const ShadowProxy>(mSource.evaluator, need, monitor);
}

double FieldRenderer::estimatedSeconds(const FieldRenderOptions& options, Monitor& monitor) {
  const double start = cpuSeconds();
  prepare(options, monitor);
  const double lattices = cpuSeconds() - start;
  Exposure exposure(mSource, mRegion, options.skip ? mOccupancy.get() : nullptr, *mShadows, options, monitor);
  return lattices + exposure.estimatedSeconds();
}

FieldImage FieldRenderer::render(const FieldRenderOptions& options, Monitor& monitor) {
  prepare(options, monitor);
  return Exposure(mSource, mRegion, options.skip ? mOccupancy.get() : nullptr, *mShadows, options, monitor).render();
}

FieldImage renderField(const FieldSource& source, const BBoxd& region, const FieldRenderOptions& options,
                       Monitor& monitor) {
  return FieldRenderer(source, region).render(options, monitor);
}

std::string encodeFieldImage(const FieldImage& image, const std::string& extension) {
  return encodeShadedImage(image, extension, false, kUsualPasses);
}

}  // namespace vdbtools
