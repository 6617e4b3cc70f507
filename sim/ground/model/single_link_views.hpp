// Single-link views: keyframes that show ground in common with one keyframe of the model only. Two images alone do not
// determine how far apart they are; the depth of the ground in the other keyframe's image does.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/model/model.hpp"
#include "sim/ground/model/placing.hpp"
#include "sim/ground/model/view_depths.hpp"

namespace ilp::model {

/// The depths by which single-link views are placed, for an adjustment.
class SingleLinkDepths {
 public:
  SingleLinkDepths(const Scene& scene, const Model& model);

  /// `depth.camera` is a view. None for a point that views measure without the single-link ones. All points of a
  /// single-link view together keep their distance within a hundredth, or the relief of the other view's ground if that
  /// is more.
  [[nodiscard]] std::optional<AdjustedDepth> of(std::size_t track) const;

 private:
  [[nodiscard]] std::optional<std::uint32_t> single_link_view(std::size_t track) const;

  const Scene& scene_;
  const Model& model_;
  std::vector<ViewDepths> below_;  ///< by rung: the depths of points that no view of this rung or above sees
  std::vector<double> sigma_;      ///< by view
};

/// Places the keyframe without a pose that shares most points, 24 or more, with one view of the model: it is resected
/// on them where the depths of that view put them. False if no such keyframe finds its place. `taken`: by unit.
[[nodiscard]] bool attach_single_link_view(const Scene& scene, const std::vector<Unit>& units,
                                           std::vector<std::uint8_t>& taken, Model& model);

/// A single-link view that shares points with two views by now becomes an ordinary one. One that has lost its points
/// leaves the model.
void review_single_link_views(const Scene& scene, Model& model);

}  // namespace ilp::model
