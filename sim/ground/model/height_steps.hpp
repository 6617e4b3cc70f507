// Measures height differences between passes over the same ground, by the flight's poses and in the joined model.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/model/joined_model.hpp"

namespace ilp::model {

/// Keyframes of one strip belong to one pass if their indices in it differ by at most this number.
inline constexpr std::int64_t keyframes_of_one_pass = 8;

/// The depth map of a keyframe inside its mask, stored sparsely by rows.
class MaskedDepth {
 public:
  MaskedDepth() = default;
  /// Decodes the depth product; empty if it is missing or cannot be decoded.
  explicit MaskedDepth(const intake::Keyframe& keyframe);

  struct Pixel {
    std::int32_t x = 0, y = 0;
    float inverse_depth = 0;  ///< 1 / unit of the keyframe's world (with its depth_scale)
  };
  template <typename Visit>
  void for_each(Visit visit) const {
    for (std::size_t y = 0; y + 1 < row_begin_.size(); ++y) {
      for (std::size_t i = row_begin_[y]; i < row_begin_[y + 1]; ++i)
        visit(Pixel{columns_[i], static_cast<std::int32_t>(y), inverse_depths_[i]});
    }
  }
  /// Bilinear inverse depth at a pixel of the real (distorted) image. 0 if one of the four pixels about it has no
  /// depth, or a depth discontinuity lies between them.
  [[nodiscard]] double at(double x, double y) const;
  [[nodiscard]] bool empty() const { return columns_.empty(); }
  [[nodiscard]] double median_depth() const;  ///< unit of the keyframe's world; 0: no depths

 private:
  [[nodiscard]] double pixel(std::int32_t x, std::int32_t y) const;

  double focal_px_ = 0;
  std::vector<std::size_t> row_begin_;
  std::vector<std::uint16_t> columns_;
  std::vector<float> inverse_depths_;
};

/// The depth map of a keyframe with its pose in a world.
struct Patch {
  std::int64_t strip_id = 0, index = 0;  ///< strip of the flight, and index of the keyframe in it
  const CameraModel* camera = nullptr;
  const MaskedDepth* depth = nullptr;
  RigidTransform camera_from_world;
  double depth_unit = 1;  ///< depth in world units = depth_unit * depth of the map
};

/// Compares patches of different passes: of different strips, or of one strip with an index difference above
/// keyframes_of_one_pass. Each pixel of the later patch is projected into the earlier camera. If the earlier patch has
/// a depth there, the step is the difference of the two surfaces' heights (world z) on this camera's line of sight,
/// divided by the mean of both depths. Earlier means first in `patches`.
[[nodiscard]] HeightSteps measure_height_steps(const std::vector<Patch>& patches);

/// Sets steps_before and steps_after of each model. The keyframes of `flight` must have been moved into the models.
void state_height_steps(const intake::Flight& flight, JoinedFlight& joined);

}  // namespace ilp::model
