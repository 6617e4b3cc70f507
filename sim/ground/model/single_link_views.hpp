// Places single-link views: keyframes that share ground with only one keyframe of the model. The points of two images
// do not determine the length of their baseline; the depths in the other keyframe's image do.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "sim/ground/model/model.hpp"
#include "sim/ground/model/placing.hpp"
#include "sim/ground/model/view_depths.hpp"

namespace ilp::model {

/// Provides an adjustment with the depths that fix the distances of single-link views.
class SingleLinkDepths {
 public:
  SingleLinkDepths(const Scene& scene, const Model& model);

  /// The depth of a track in the view that a single-link view is attached to; `camera` is a view's index, and `point`
  /// is not set. None if other views than single-link ones measure the point. The sigmas are such that all points of a
  /// single-link view together fix the distance to 1 %, or to the relief of the ground relative to the depth if that is
  /// more.
  [[nodiscard]] std::optional<AdjustedDepth> of(std::size_t track) const;

 private:
  [[nodiscard]] std::optional<std::uint32_t> single_link_view(std::size_t track) const;

  const Scene& scene_;
  const Model& model_;
  std::vector<ViewDepths> below_;  ///< for each rung, depths of points that only views of lower rungs see
  std::vector<double> sigma_;      ///< for each view, relative sigma of its depths
};

/// Places one keyframe without a pose: that which shares most points, at least 24, with one view of the model and can
/// be resected on them. The depths of the model's view give the positions of the points. Returns false if there is no
/// such keyframe. `taken`: for each unit, not 0 if it is in a model; is updated.
[[nodiscard]] bool attach_single_link_view(const Scene& scene, const std::vector<Unit>& units,
                                           std::vector<std::uint8_t>& taken, Model& model);

/// Makes a single-link view an ordinary one if it now shares enough points with two views (rung_by_points). Removes a
/// single-link view with too few points from the model.
void review_single_link_views(const Scene& scene, Model& model);

}  // namespace ilp::model
