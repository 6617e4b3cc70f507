// Base of the parts that process a strip: state, workspace, and functions that all parts use.
#pragma once

#include <algorithm>

#include "fsw/vision/multiview/resection.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"

namespace ilp {

class SequencePart {
 public:
  SequencePart(SequenceState& state, SequenceWorkspace& workspace) : s_(state), w_(workspace) {}

 protected:
  void fail(SequenceVerdict verdict);
  /// Ordinal of the newest keyframe.
  [[nodiscard]] std::uint32_t newest() const { return s_.oldest + static_cast<std::uint32_t>(s_.cameras.size()) - 1; }
  /// Index of the camera that the current keyframe is matched with: the newest one or a slightly older one.
  [[nodiscard]] std::size_t base_index() const { return s_.cameras.size() - 1 - s_.back; }
  [[nodiscard]] double focal_px() const { return std::max(s_.camera.fx, s_.camera.fy); }
  [[nodiscard]] RansacParams two_view_params(std::uint64_t seed) const;
  [[nodiscard]] ResectionParams resection_params(std::uint64_t seed) const;
  /// Adds the current keyframe to the strip. The oldest camera leaves if the capacity is exhausted.
  void push_camera(const RigidTransform& cam_from_world, bool posed = true);
  void scale_to_first_height();

  SequenceState& s_;
  SequenceWorkspace& w_;
};

}  // namespace ilp
