// Where a strip lies in the world of an earlier one, by the links between their keyframes.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/records/records.hpp"
#include "fsw/vision/geometry/similarity.hpp"

namespace ilp {

/// What one link says: the world of the earlier strip from that of this one, and the covariance of a step of this
/// world before it. `unit_covariance` is the part of it that the units of both strips cause: all links of the strip
/// have this error in common.
struct LinkedWorld {
  std::int64_t keyframe_id = 0;
  std::int64_t to_strip_id = 0;
  double q_to_from_this[4] = {1, 0, 0, 0};
  double translation[3] = {0, 0, 0};
  double scale = 1;
  double covariance[similarity_covariance_elements] = {};
  double unit_covariance[similarity_covariance_elements] = {};
};

/// The links of one strip. With more, the oldest is overwritten: they stand for the beginning of the strip.
struct StripLinks {
  static constexpr std::size_t capacity = 24;
  std::int64_t strip_id = 0;
  std::uint64_t added = 0;
  std::array<LinkedWorld, capacity> links{};
};

/// The links of another strip are dropped.
void add_link(std::int64_t strip_id, const LinkedWorld& link, StripLinks& links);

/// The mean of the links that agree with each other best, weighted by their covariances, to the earliest strip for
/// which links of two keyframes agree. The errors of the units do not become smaller by more links. False if there is
/// none.
[[nodiscard]] bool tie_strip(const StripLinks& links, TieRecord& tie);

/// The world of the earlier strip from that of the newer one, from a link and the poses of both keyframes, whose
/// covariances (of rotation vector and centre, zero when not known) are part of the result's. The first baseline
/// defines the unit of a strip, and the strip drifts from it, so that a link has the unit of the place where it is. The
/// error of this unit is taken to be the estimated error of the centre along the way from the strip's first camera, as
/// a share of this way.
[[nodiscard]] LinkedWorld linked_world(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place);

/// The step from the similarity that the poses of one strip say to that of the link, in the newer camera's frame, and
/// its covariance by link and poses.
struct LoopError {
  SimilarityStep step;
  SimilarityCovariance covariance;
};
[[nodiscard]] LoopError loop_error(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place);

/// Whether the pose's errors are known. Those of the first keyframe of a strip are 0, because it defines the world.
[[nodiscard]] bool has_covariance(const PoseRecord& pose);

/// How the ground before a camera, in the middle of its image, moves with the unknowns of SimilarityCovariance.
[[nodiscard]] Eigen::Matrix<double, 3, 7> ground_by_step(double distance);

/// One sigma of where two poses of a strip put the ground before the newer camera, as a share of its distance: by both
/// covariances, as if they were independent.
[[nodiscard]] double ground_error_of_poses(const PoseRecord& keyframe, const PoseRecord& place, double distance);

/// One sigma of where the link puts a point, in the frame and the unit of its newer camera.
[[nodiscard]] double error_of_link_at(const LinkRecord& link, const Vec3& point);

[[nodiscard]] Similarity similarity_of(const LinkRecord& link);
[[nodiscard]] Similarity similarity_of(const TieRecord& tie);

}  // namespace ilp
