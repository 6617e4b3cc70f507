// Loads true poses and depths of the images of a flight, by name, and keeps a sampled version of them.
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

/// Keeps the sampled frames, which have one depth per block (world::sample_stride), so that those of an entire flight
/// fit into memory.
class TrueFrames {
 public:
  /// Keeps a reference to `reference`. `camera` is the true camera, which may differ from the flight's camera.
  TrueFrames(const report::Reference& reference, const CameraModel& camera) : reference_(reference), camera_(camera) {}

  /// The sampled frame. Null if pose or depth is not known, or if the depth does not have the camera's size.
  [[nodiscard]] const world::TrueFrame* sampled(const std::string& name);
  /// The frame with every pixel, which is not kept. Empty where `sampled` is null.
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

/// All keyframes with a true frame, in the order of ids.
[[nodiscard]] std::vector<KeyframeTruth> keyframes_with_truth(const intake::Flight& flight, TrueFrames& truth);

}  // namespace ilp::score
