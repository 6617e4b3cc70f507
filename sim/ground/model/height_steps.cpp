#include "sim/ground/model/height_steps.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include "fsw/vision/geometry/camera.hpp"
#include "sim/ground/intake/keyframe_rasters.hpp"
#include "sim/ground/model/model.hpp"
#include "sim/ground/model/ties.hpp"
#include "sim/host/parallel.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::model {
namespace {

/// Neighbouring pixels whose depths differ by more than this many times their distance on the ground are two surfaces.
constexpr double max_depth_jump = 4;
/// Side of the cells by which pieces over the same ground are found, as a share of the flying height.
constexpr double cell_share = 0.05;

intake::Keyframe depth_only(const intake::Keyframe& keyframe) {
  constexpr auto kind = static_cast<std::size_t>(ProductKind::depth);
  intake::Keyframe depth;
  depth.mask = keyframe.mask;
  depth.inverse_depth = keyframe.inverse_depth;
  depth.product_files[kind] = keyframe.product_files[kind];
  depth.depth_scale = keyframe.depth_scale;
  depth.mask_width = keyframe.mask_width;
  depth.mask_height = keyframe.mask_height;
  depth.coded_mask = keyframe.coded_mask;
  return depth;
}

Vec3 world_point(const Patch& patch, const MaskedDepth::Pixel& pixel) {
  const Vec2 n = normalised_from_pixel(*patch.camera, Vec2(pixel.x, pixel.y));
  const RigidTransform& pose = patch.camera_from_world;
  const double depth = patch.depth_unit / pixel.inverse_depth;
  return pose.rotation.transpose() * (depth * Vec3(n.x(), n.y(), 1) - pose.translation);
}

bool of_one_pass(const Patch& a, const Patch& b) {
  return a.strip_id == b.strip_id && std::abs(a.index - b.index) <= keyframes_of_one_pass;
}

/// Which pieces lie over which cells of the ground.
class Cells {
 public:
  explicit Cells(const std::vector<Patch>& patches) {
    std::vector<double> depths;
    depths.reserve(patches.size());
    for (const Patch& patch : patches) depths.push_back(patch.depth_unit * patch.depth->median_depth());
    side_ = cell_share * host::median(std::move(depths));
    for (std::size_t i = 0; i < patches.size(); ++i) {
      patches[i].depth->for_each([&](const MaskedDepth::Pixel& pixel) {
        std::vector<std::uint32_t>& over = cells_[key(world_point(patches[i], pixel))];
        if (over.empty() || over.back() != i) over.push_back(static_cast<std::uint32_t>(i));
      });
    }
  }
  [[nodiscard]] const std::vector<std::uint32_t>& over(const Vec3& point) const { return cells_.at(key(point)); }

 private:
  [[nodiscard]] std::uint64_t key(const Vec3& point) const {
    const auto part = [&](double c) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(
          static_cast<std::int32_t>(std::clamp(std::floor(c / side_), -2147483648.0, 2147483647.0))));
    };
    return part(point.x()) << 32U | part(point.y());
  }

  double side_ = 1;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> cells_;
};

/// The step between a point of a later piece, which lies `depth` from its camera, and an earlier piece; NaN where the
/// earlier one has no depth there. % of the mean distance.
double step_percent(const Vec3& point, double depth, const Patch& earlier) {
  const RigidTransform& pose = earlier.camera_from_world;
  const Vec3 in_camera = pose * point;
  if (!(in_camera.z() > 0)) return unknown;
  const Vec2 px = pixel_from_normalised(*earlier.camera, in_camera.head<2>() / in_camera.z());
  const double inverse = earlier.depth->at(px.x(), px.y());
  if (!(inverse > 0)) return unknown;
  const double depth_there = earlier.depth_unit / inverse;
  const Vec3 apart = pose.rotation.transpose() * (in_camera * (1 - depth_there / in_camera.z()));
  return 100 * std::fabs(apart.z()) / (0.5 * (depth + depth_there));
}

struct Steps {
  std::vector<double> percent;
  std::set<std::uint32_t> earlier;  ///< pieces that it was compared with
};

Steps steps_of(const std::vector<Patch>& patches, std::uint32_t number, const Cells& cells) {
  Steps steps;
  const Patch& patch = patches[number];
  patch.depth->for_each([&](const MaskedDepth::Pixel& pixel) {
    const Vec3 point = world_point(patch, pixel);
    for (const std::uint32_t other : cells.over(point)) {
      if (other >= number) break;
      if (of_one_pass(patches[other], patch)) continue;
      const double percent = step_percent(point, patch.depth_unit / pixel.inverse_depth, patches[other]);
      if (!std::isfinite(percent)) continue;
      steps.percent.push_back(percent);
      steps.earlier.insert(other);
    }
  });
  return steps;
}

std::map<std::int64_t, std::int64_t> indices_in_strip(const JoinedModel& joined) {
  std::map<std::int64_t, std::int64_t> index, used;
  for (const JoinedModel::Member& member : joined.members) index[member.keyframe_id] = used[member.strip_id]++;
  return index;
}

using Depths = std::map<std::int64_t, MaskedDepth>;  ///< by keyframe

Depths depths_of(const intake::Flight& flight, const JoinedModel& joined) {
  std::vector<MaskedDepth> decoded(joined.members.size());
  host::for_each_parallel(decoded.size(), [&](std::size_t i) {
    const intake::Keyframe& keyframe = flight.keyframes.at(joined.members[i].keyframe_id);
    if (validate(keyframe.camera).ok()) decoded[i] = MaskedDepth(keyframe);
  });
  Depths depths;
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    if (!decoded[i].empty()) depths.emplace(joined.members[i].keyframe_id, std::move(decoded[i]));
  }
  return depths;
}

/// The pieces of the model by the poses of the flight, for each world that ties make of the strips.
std::map<std::int64_t, std::vector<Patch>> patches_before(const intake::Flight& flight, const JoinedModel& joined,
                                                          const Depths& depths) {
  const std::map<std::int64_t, TiedWorld> worlds = tied_worlds(flight);
  std::map<std::int64_t, std::int64_t> index = indices_in_strip(joined);
  std::map<std::int64_t, std::vector<Patch>> patches;
  for (const JoinedModel::Member& member : joined.members) {
    const auto depth = depths.find(member.keyframe_id);
    const auto world = worlds.find(member.strip_id);
    if (!member.posed_by_flight || depth == depths.end() || world == worlds.end()) continue;
    const intake::Keyframe& keyframe = flight.keyframes.at(member.keyframe_id);
    const Similarity& from_strip = world->second.world_from_strip;
    patches[world->second.strip_id].push_back({member.strip_id, index[member.keyframe_id], &keyframe.camera,
                                               &depth->second, moved(from_strip, member.camera_from_strip),
                                               from_strip.scale * member.depth_scale / keyframe.depth_scale});
  }
  return patches;
}

std::vector<Patch> patches_after(const intake::Flight& flight, const JoinedModel& joined, const Depths& depths) {
  std::map<std::int64_t, std::int64_t> index = indices_in_strip(joined);
  std::vector<Patch> patches;
  for (const JoinedModel::Member& member : joined.members) {
    const auto depth = depths.find(member.keyframe_id);
    if (depth == depths.end()) continue;
    const intake::Keyframe& keyframe = flight.keyframes.at(member.keyframe_id);
    patches.push_back({member.strip_id, index[member.keyframe_id], &keyframe.camera, &depth->second,
                       cam_from_world(pose_of(*keyframe.pose)), 1});
  }
  return patches;
}

HeightSteps summary_of(std::vector<double> percent, std::size_t pairs) {
  HeightSteps steps{percent.size(), pairs};
  if (percent.empty()) return steps;
  steps.p95_percent = host::percentile(percent, 0.95);
  steps.median_percent = host::median(std::move(percent));
  return steps;
}

void measure(const std::vector<Patch>& patches, std::vector<double>& percent, std::size_t& pairs) {
  if (patches.empty()) return;
  const Cells cells(patches);
  std::vector<Steps> steps(patches.size());
  host::for_each_parallel(patches.size(),
                          [&](std::size_t i) { steps[i] = steps_of(patches, static_cast<std::uint32_t>(i), cells); });
  for (const Steps& one : steps) {
    percent.insert(percent.end(), one.percent.begin(), one.percent.end());
    pairs += one.earlier.size();
  }
}

}  // namespace

MaskedDepth::MaskedDepth(const intake::Keyframe& keyframe) : focal_px_(keyframe.camera.fx) {
  const intake::KeyframeRasters rasters = intake::decode_products(depth_only(keyframe)).rasters;
  const host::Raster<float>& inverse = rasters.inverse_depth;
  if (!inverse.same_size(keyframe.camera.width, keyframe.camera.height)) return;
  row_begin_.push_back(0);
  for (std::int32_t y = 0; y < inverse.height; ++y) {
    for (std::int32_t x = 0; x < inverse.width; ++x) {
      if (!(inverse.at(x, y) > 0)) continue;
      columns_.push_back(static_cast<std::uint16_t>(x));
      inverse_depths_.push_back(inverse.at(x, y));
    }
    row_begin_.push_back(columns_.size());
  }
}

double MaskedDepth::pixel(std::int32_t x, std::int32_t y) const {
  if (x < 0 || y < 0 || static_cast<std::size_t>(y) + 1 >= row_begin_.size()) return 0;
  const auto begin = columns_.begin() + static_cast<std::ptrdiff_t>(row_begin_[static_cast<std::size_t>(y)]);
  const auto end = columns_.begin() + static_cast<std::ptrdiff_t>(row_begin_[static_cast<std::size_t>(y) + 1]);
  const auto at = std::lower_bound(begin, end, x);
  return at != end && *at == x ? static_cast<double>(inverse_depths_[static_cast<std::size_t>(at - columns_.begin())])
                               : 0.0;
}

double MaskedDepth::at(double x, double y) const {
  constexpr double farthest_px = 65534;
  if (!(x >= 0 && y >= 0 && x < farthest_px && y < farthest_px)) return 0;
  const auto x0 = static_cast<std::int32_t>(x), y0 = static_cast<std::int32_t>(y);
  const double a = pixel(x0, y0), b = pixel(x0 + 1, y0), c = pixel(x0, y0 + 1), d = pixel(x0 + 1, y0 + 1);
  const auto [least, most] = std::minmax({a, b, c, d});
  if (!(least > 0)) return 0;
  if (1 / least - 1 / most > max_depth_jump / (most * focal_px_)) return 0;
  const double u = x - x0, v = y - y0;
  return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d);
}

double MaskedDepth::median_depth() const {
  return inverse_depths_.empty() ? 0 : 1 / host::median({inverse_depths_.begin(), inverse_depths_.end()});
}

HeightSteps measure_height_steps(const std::vector<Patch>& patches) {
  std::vector<double> percent;
  std::size_t pairs = 0;
  measure(patches, percent, pairs);
  return summary_of(std::move(percent), pairs);
}

void state_height_steps(const intake::Flight& flight, JoinedFlight& joined) {
  for (JoinedModel& one : joined.models) {
    const Depths depths = depths_of(flight, one);
    std::vector<double> before;
    std::size_t pairs = 0;
    for (const auto& [world, patches] : patches_before(flight, one, depths)) measure(patches, before, pairs);
    one.steps_before = summary_of(std::move(before), pairs);
    one.steps_after = measure_height_steps(patches_after(flight, one, depths));
  }
}

}  // namespace ilp::model
