// What every part of the work on a strip has: its state, its scratch, and what they all need to know or do.
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
  /// Index of the camera that the keyframe at work is matched with: the newest one, or one a little older.
  [[nodiscard]] std::size_t base_index() const { return s_.cameras.size() - 1 - s_.back; }
  [[nodiscard]] double focal_px() const { return std::max(s_.camera.fx, s_.camera.fy); }
  [[nodiscard]] RansacParams two_view_params(std::uint64_t seed) const;
  [[nodiscard]] ResectionParams resection_params(std::uint64_t seed) const;
  /// The keyframe at work joins the strip. The oldest camera leaves if there is no room.
  void push_camera(const RigidTransform& cam_from_world, bool posed = true);
  void scale_to_first_height();

  SequenceState& s_;
  SequenceWorkspace& w_;
};

}  // namespace ilp
