// Ties a strip to an earlier one: the similarity between their world frames, from links between their keyframes.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/similarity.hpp"

namespace ilp {

/// The similarity from one link: the world frame of the earlier strip from that of this strip. `covariance` is that of
/// a step in this strip's frame. `unit_covariance` is the part of it that is due to the units of both strips; this
/// error is common to all links of the strip.
struct LinkedWorld {
  std::int64_t keyframe_id = 0;
  std::int64_t to_strip_id = 0;
  double q_to_from_this[4] = {1, 0, 0, 0};
  double translation[3] = {0, 0, 0};
  double scale = 1;
  double covariance[similarity_covariance_elements] = {};
  double unit_covariance[similarity_covariance_elements] = {};
};

/// The links of one strip. When they exceed the capacity, the oldest one is overwritten.
struct StripLinks {
  static constexpr std::size_t capacity = 24;
  std::int64_t strip_id = 0;
  std::uint64_t added = 0;
  std::array<LinkedWorld, capacity> links{};
};

/// Adds a link of strip `strip_id`. Links of another strip are dropped.
void add_link(std::int64_t strip_id, const LinkedWorld& link, StripLinks& links);

/// Computes the tie to the earliest strip for which links of at least two keyframes agree: the mean of the largest set
/// of agreeing links, weighted by their covariances. More links do not reduce the errors of the units. Returns false if
/// no links agree.
[[nodiscard]] bool tie_strip(const StripLinks& links, TieRecord& tie);

/// Computes the world frame of the earlier strip from that of the newer strip, from a link and the poses of both
/// keyframes, whose covariances (of rotation vector and centre; zero if not known) contribute to the result's. The
/// first baseline defines the unit of a strip, but the scale drifts, so that a link refers to the scale at its
/// keyframes. The relative error of this scale is taken to be the estimated error of the camera centre along the line
/// from the strip's first camera, divided by the length of this line.
[[nodiscard]] LinkedWorld linked_world(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place);

/// Error of a loop within one strip: the step, in the newer camera's frame, from the similarity according to the poses
/// to that of the link, and the covariance of this step from link and poses.
struct LoopError {
  SimilarityStep step;
  SimilarityCovariance covariance;
};
[[nodiscard]] LoopError loop_error(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place);

/// Whether the pose's errors are known. Those of the first keyframe of a strip are 0, because it defines the world.
[[nodiscard]] bool has_covariance(const PoseRecord& pose);

/// Derivative of the ground point at the image centre, at this distance, with respect to the unknowns of
/// SimilarityCovariance.
[[nodiscard]] Eigen::Matrix<double, 3, 7> ground_by_step(double distance);

/// Standard deviation of the position of the newer camera's ground relative to the other keyframe, from the poses of
/// both, divided by `distance`. The covariances of both poses are treated as independent.
[[nodiscard]] double ground_error_of_poses(const PoseRecord& keyframe, const PoseRecord& place, double distance);

/// Standard deviation of the position of a point that the link maps, in the frame and the unit of the newer camera.
[[nodiscard]] double error_of_link_at(const LinkRecord& link, const Vec3& point);

[[nodiscard]] Similarity similarity_of(const LinkRecord& link);
[[nodiscard]] Similarity similarity_of(const TieRecord& tie);

}  // namespace ilp
