// How far the heights of two passes over the same ground differ, by the flight's poses and in the joined model.
#pragma once

#include <cstdint>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/model/joined_model.hpp"

namespace ilp::model {

/// Keyframes of one strip that are this near to each other in it belong to one pass.
inline constexpr std::int64_t keyframes_of_one_pass = 8;

/// The depths of a keyframe where its mask is set, row by row.
class MaskedDepth {
 public:
  MaskedDepth() = default;
  /// Decodes the depth product; empty where it does not decode or none came down.
  explicit MaskedDepth(const intake::Keyframe& keyframe);

  struct Pixel {
    std::int32_t x = 0, y = 0;
    float inverse_depth = 0;  ///< in the unit of the keyframe's depth_scale
  };
  template <typename Visit>
  void for_each(Visit visit) const {
    for (std::size_t y = 0; y + 1 < row_begin_.size(); ++y) {
      for (std::size_t i = row_begin_[y]; i < row_begin_[y + 1]; ++i)
        visit(Pixel{columns_[i], static_cast<std::int32_t>(y), inverse_depths_[i]});
    }
  }
  /// Bilinear inverse depth at a pixel of the real image; 0 where one of the four pixels about it has none, or their
  /// depths jump.
  [[nodiscard]] double at(double x, double y) const;
  [[nodiscard]] bool empty() const { return columns_.empty(); }
  [[nodiscard]] double median_depth() const;

 private:
  [[nodiscard]] double pixel(std::int32_t x, std::int32_t y) const;

  double focal_px_ = 0;
  std::vector<std::size_t> row_begin_;
  std::vector<std::uint16_t> columns_;
  std::vector<float> inverse_depths_;
};

/// A keyframe's depths in a world.
struct Patch {
  std::int64_t strip_id = 0, index = 0;  ///< strip of the flight, and its number in it
  const CameraModel* camera = nullptr;
  const MaskedDepth* depth = nullptr;
  RigidTransform camera_from_world;
  double depth_unit = 1;  ///< world units for a unit of the depths
};

/// Compares the pieces of different strips, and of one strip where more than keyframes_of_one_pass lie between them.
/// Where a pixel of the later piece is seen in the earlier one, the step is the difference of the heights (z of the
/// world) of the two surfaces on the line of sight of the earlier camera, divided by the mean distance of both cameras
/// along their axes. The order of the pieces decides which is earlier.
[[nodiscard]] HeightSteps measure_height_steps(const std::vector<Patch>& patches);

/// Measures the steps of each model. `flight` has been moved into them.
void state_height_steps(const intake::Flight& flight, JoinedFlight& joined);

}  // namespace ilp::model
