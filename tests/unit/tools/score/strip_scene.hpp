// A strip over level ground as the ground station would hold it, and its truth: everything is known by hand.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/world/height_grid.hpp"

namespace ilp::test {

struct TableReference final : report::Reference {
  std::map<std::string, report::ReferencePose> poses;
  std::map<std::string, host::Raster<float>> depths;

  [[nodiscard]] const report::ReferencePose* pose(const std::string& name) const override {
    const auto found = poses.find(name);
    return found == poses.end() ? nullptr : &found->second;
  }
  [[nodiscard]] host::Raster<float> depth(const std::string& name) const override {
    const auto found = depths.find(name);
    return found == depths.end() ? host::Raster<float>() : found->second;
  }
};

/// Nadir views 100 m above level ground, on a line along x; the footprint is 1 m a pixel. The strip's world is the
/// true one turned, shifted and in units of `unit` m. Depths and masks are perfect.
struct StripScene {
  static constexpr int width = 160, height = 120;
  static constexpr double flying_height = 100;
  double unit = 1;
  std::vector<double> x;  ///< of the cameras, m: multiples of 1 m keep footprints on whole pixels
  intake::Flight flight;
  TableReference truth;

  explicit StripScene(std::vector<double> positions = {0, 30, 60, 90, 120}, double unit_m = 4)
      : unit(unit_m), x(std::move(positions)) {
    const Mat3 nadir = Vec3(1, -1, -1).asDiagonal();
    const Mat3 turn = rotation_from_vector(Vec3(0.3, -0.2, 0.5));  // strip from true
    CameraModel camera{width, height, 100, 100, 79.5, 59.5, 0, 0, 0, 0};
    flight.camera = camera;
    intake::Strip& strip = flight.strips[1];
    strip.id = 1;
    for (std::size_t k = 0; k < x.size(); ++k) {
      const auto id = static_cast<std::int64_t>(k) + 1;
      strip.keyframes.push_back(id);
      intake::Keyframe& keyframe = flight.keyframes[id];
      keyframe.id = id;
      keyframe.strip_id = 1;
      keyframe.name = name_of(k);
      keyframe.camera = camera;
      keyframe.record = KeyframeRecord{};
      keyframe.record->id = keyframe.record->frame_id = id;
      const Vec3 centre(x[k], 0, flying_height);
      truth.poses[keyframe.name] = {nadir, centre};
      truth.depths[keyframe.name] = host::Raster<float>(width, height, static_cast<float>(flying_height));
      keyframe.pose = PoseRecord{};
      keyframe.pose->state = PoseState::final;
      quaternion_from_rotation(nadir * turn.transpose(), keyframe.pose->q_cam_from_world);
      const Vec3 strip_centre = turn * (centre - Vec3(7, -3, 50)) / unit;
      for (int i = 0; i < 3; ++i) keyframe.pose->centre[i] = strip_centre[i];
      add_dense(k, keyframe);
    }
  }

  static std::string name_of(std::size_t k) { return "000" + std::to_string(k + 1) + ".pgm"; }
  intake::Keyframe& keyframe(std::size_t k) { return flight.keyframes.at(static_cast<std::int64_t>(k) + 1); }
  [[nodiscard]] double ground_x(std::size_t k, int column) const { return x[k] + column - 79.5; }
  [[nodiscard]] bool sees(std::size_t k, double at) const { return std::fabs(at - x[k]) <= 80; }

  /// The mask that decisions.md, 9 asks for, on a line.
  [[nodiscard]] bool newly_seen(std::size_t k, int column) const {
    const double at = ground_x(k, column);
    if (k + 1 < x.size() && !sees(k + 1, at)) return false;
    for (std::size_t i = 0; i < k; ++i) {
      if (sees(i, at) && sees(i + 1, at)) return false;
    }
    return true;
  }

  /// Multiplies the depths by factor(keyframe, column, row).
  template <typename Factor>
  void distort(Factor factor) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      host::Raster<float>& inverse = keyframe(k).inverse_depth;
      for (int row = 0; row < inverse.height; ++row) {
        for (int column = 0; column < inverse.width; ++column) {
          inverse.at(column, row) = static_cast<float>(inverse.at(column, row) / factor(k, column, row));
        }
      }
    }
  }

  [[nodiscard]] static world::HeightGrid true_heights() {
    world::HeightGrid grid{-200, 200, 1, host::Raster<float>(801, 401, 0)};
    return grid;
  }

 private:
  void add_dense(std::size_t k, intake::Keyframe& keyframe) const {
    const bool has_partner = k + 1 < x.size();
    keyframe.mask = host::Raster<std::uint8_t>(width, height);
    if (has_partner) keyframe.inverse_depth = host::Raster<float>(width, height);
    for (int row = 0; row < height; ++row) {
      for (int column = 0; column < width; ++column) {
        if (!newly_seen(k, column)) continue;
        keyframe.mask.at(column, row) = 255;
        if (has_partner) keyframe.inverse_depth.at(column, row) = static_cast<float>(unit / flying_height);
      }
    }
    keyframe.depth = DepthRecord{};
    keyframe.depth->id = keyframe.id;
    keyframe.depth->verdict = has_partner ? DepthVerdict::ok : DepthVerdict::no_partner;
    keyframe.depth->partner_id = has_partner ? keyframe.id + 1 : 0;
  }
};

}  // namespace ilp::test
