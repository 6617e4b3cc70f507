// The true frames of the images of a flight, by name.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/ground/intake/flight_model.hpp"
#include "sim/ground/report/accuracy.hpp"
#include "sim/world/visibility.hpp"

namespace ilp::score {

/// Holds one depth sample in a block for every image asked for (world::sample_stride), so that a whole flight fits.
class TrueFrames {
 public:
  /// Borrows the reference. The camera is the true one, which the flight may have known wrongly.
  TrueFrames(const report::Reference& reference, const CameraModel& camera) : reference_(reference), camera_(camera) {}

  /// Null when pose or depth are not known or the depth has another size than the camera.
  [[nodiscard]] const world::TrueFrame* sampled(const std::string& name);
  /// Every pixel; not held.
  [[nodiscard]] std::optional<world::TrueFrame> whole(const std::string& name) const;

  [[nodiscard]] const report::Reference& reference() const { return reference_; }
  [[nodiscard]] const CameraModel& camera() const { return camera_; }

 private:
  [[nodiscard]] std::optional<world::TrueFrame> load(const std::string& name, std::int32_t stride) const;

  const report::Reference& reference_;
  CameraModel camera_;
  std::map<std::string, std::unique_ptr<world::TrueFrame>> sampled_;
};

struct KeyframeTruth {
  const intake::Keyframe* keyframe = nullptr;
  const world::TrueFrame* frame = nullptr;
};

/// All keyframes with a true frame, by id.
[[nodiscard]] std::vector<KeyframeTruth> keyframes_with_truth(const intake::Flight& flight, TrueFrames& truth);

}  // namespace ilp::score
