#include "fsw/places/strip_tie.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "fsw/vision/geometry/symmetric_solver.hpp"

namespace ilp {
namespace {

/// 99 % of the squared distances of two estimates of seven unknowns lie below it.
constexpr double largest_disagreement = 18.5;

Similarity similarity_of(const double (&q)[4], const double (&translation)[3], double scale) {
  return {rotation_from_quaternion(q), Vec3(translation[0], translation[1], translation[2]), scale};
}

Similarity similarity_of(const LinkedWorld& link) {
  return similarity_of(link.q_to_from_this, link.translation, link.scale);
}

/// From the estimate of `a` to that of `b`, as a step of the newer strip's world.
SimilarityStep difference(const LinkedWorld& a, const LinkedWorld& b) {
  return step_between(Similarity{}, compose(inverse(similarity_of(a)), similarity_of(b)));
}

bool agree(const LinkedWorld& a, const LinkedWorld& b) {
  const SimilarityStep step = difference(a, b);
  const SimilarityCovariance covariance = unpack_covariance(a.covariance) + unpack_covariance(b.covariance);
  return step.dot(solve_symmetric<7>(covariance, step)) < largest_disagreement;
}

/// Of rotation vector and centre.
Eigen::Matrix<double, 6, 6> covariance_of_pose(const PoseRecord& pose) {
  Eigen::Matrix<double, 6, 6> covariance;
  int element = 0;
  for (int row = 0; row < 6; ++row) {
    for (int column = 0; column <= row; ++column) {
      covariance(row, column) = covariance(column, row) = pose.covariance[element++];
    }
  }
  return covariance;
}

/// Errors of a pose as a step in its camera's frame.
SimilarityCovariance pose_covariance(const PoseRecord& pose) {
  Eigen::Matrix<double, 7, 6> map = Eigen::Matrix<double, 7, 6>::Zero();
  map.block<3, 3>(0, 0) = Mat3::Identity();
  map.block<3, 3>(3, 3) = -rotation_from_quaternion(pose.q_cam_from_world);
  return map * covariance_of_pose(pose) * map.transpose();
}

/// The error of the unit where the camera of a pose is, as a step of the strip's world, whose scale it is. A short way
/// from the first camera says little about the unit: half of the ground's distance is the least that counts.
SimilarityCovariance unit_covariance(const PoseRecord& pose) {
  const Mat3 covariance = covariance_of_pose(pose).bottomRightCorner<3, 3>();
  const Vec3 way(pose.centre[0], pose.centre[1], pose.centre[2]);
  const double least = pose.ground_distance / 2;
  const double squared = std::max(way.squaredNorm(), least * least);
  SimilarityCovariance unit = SimilarityCovariance::Zero();
  if (squared > 0) unit(6, 6) = way.dot(covariance * way) / (squared * squared);
  return unit;
}

Similarity camera_of(const PoseRecord& pose) {
  return similarity_from(cam_from_world(pose_of(pose)));
}

/// Errors of both poses, as a step in the newer camera's frame.
SimilarityCovariance covariance_of(const Similarity& keyframe_from_place, const PoseRecord& keyframe,
                                   const PoseRecord& place) {
  const SimilarityCovariance map = step_in_other_frame(keyframe_from_place);
  return pose_covariance(keyframe) + map * pose_covariance(place) * map.transpose();
}

/// Errors of the link and of both poses, as a step in the newer camera's frame.
SimilarityCovariance covariance_of(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place) {
  return unpack_covariance(link.covariance) + covariance_of(similarity_of(link), keyframe, place);
}

struct Consensus {
  std::size_t reference = 0;
  std::uint32_t links = 0;
};

/// The link of this strip pair with which most others agree, if these are of two keyframes at least.
Consensus find_consensus(const StripLinks& links, std::size_t count, std::int64_t to_strip_id) {
  Consensus best;
  for (std::size_t i = 0; i < count; ++i) {
    if (links.links[i].to_strip_id != to_strip_id) continue;
    std::uint32_t agreeing = 1;
    bool other_keyframe = false;
    for (std::size_t j = 0; j < count; ++j) {
      if (j == i || links.links[j].to_strip_id != to_strip_id || !agree(links.links[i], links.links[j])) continue;
      ++agreeing;
      other_keyframe = other_keyframe || links.links[j].keyframe_id != links.links[i].keyframe_id;
    }
    if (other_keyframe && agreeing > best.links) best = {i, agreeing};
  }
  return best;
}

}  // namespace

Similarity similarity_of(const LinkRecord& link) {
  return similarity_of(link.q_keyframe_from_place, link.translation, link.scale);
}

Similarity similarity_of(const TieRecord& tie) {
  return similarity_of(tie.q_to_from_this, tie.translation, tie.scale);
}

void add_link(std::int64_t strip_id, const LinkedWorld& link, StripLinks& links) {
  if (links.strip_id != strip_id) links = {};
  links.strip_id = strip_id;
  links.links[links.added % StripLinks::capacity] = link;
  ++links.added;
}

bool tie_strip(const StripLinks& links, TieRecord& tie) {
  const std::size_t count = std::min<std::size_t>(links.added, StripLinks::capacity);
  std::int64_t to_strip_id = 0;
  Consensus best;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t id = links.links[i].to_strip_id;
    if (best.links != 0 && id >= to_strip_id) continue;
    const Consensus consensus = find_consensus(links, count, id);
    if (consensus.links == 0) continue;
    best = consensus;
    to_strip_id = id;
  }
  if (best.links == 0) return false;

  const LinkedWorld& reference = links.links[best.reference];
  SimilarityCovariance information = SimilarityCovariance::Zero();
  SimilarityCovariance of_links = SimilarityCovariance::Zero(), of_units = SimilarityCovariance::Zero();
  SimilarityStep weighted = SimilarityStep::Zero();
  tie = {};
  for (std::size_t i = 0; i < count; ++i) {
    const LinkedWorld& link = links.links[i];
    if (link.to_strip_id != to_strip_id) continue;
    if (i != best.reference && !agree(reference, link)) {
      ++tie.refused;
      continue;
    }
    const SimilarityCovariance covariance = unpack_covariance(link.covariance);
    const SimilarityCovariance units = unpack_covariance(link.unit_covariance);
    const SimilarityCovariance weight = inverse_of_symmetric<7>(covariance);
    information += weight;
    of_links += weight * (covariance - units) * weight;
    of_units += units;
    weighted += weight * difference(reference, link);
    tie.through_keyframe_id = std::max(tie.through_keyframe_id, link.keyframe_id);
    ++tie.links;
  }
  const SimilarityStep mean = solve_symmetric<7>(information, weighted);
  if (!mean.allFinite()) return false;
  const Similarity to_from_this = compose(similarity_of(reference), stepped(mean, Similarity{}));
  tie.id = links.strip_id;
  tie.to_strip_id = to_strip_id;
  quaternion_from_rotation(to_from_this.rotation, tie.q_to_from_this);
  for (int i = 0; i < 3; ++i) tie.translation[i] = to_from_this.translation(i);
  tie.scale = to_from_this.scale;
  const SimilarityCovariance of_mean = inverse_of_symmetric<7>(information);
  pack_covariance(of_mean * of_links * of_mean + of_units / static_cast<double>(tie.links), tie.covariance);
  return true;
}

LinkedWorld linked_world(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place) {
  const Similarity cam_from_this = camera_of(keyframe);
  const Similarity to_from_this =
      compose(inverse(camera_of(place)), compose(inverse(similarity_of(link)), cam_from_this));
  const SimilarityCovariance map = step_in_other_frame(inverse(cam_from_this));
  LinkedWorld world;
  world.keyframe_id = link.keyframe_id;
  world.to_strip_id = link.place_strip_id;
  quaternion_from_rotation(to_from_this.rotation, world.q_to_from_this);
  for (int i = 0; i < 3; ++i) world.translation[i] = to_from_this.translation(i);
  world.scale = to_from_this.scale;
  const SimilarityCovariance this_from_to = step_in_other_frame(inverse(to_from_this));
  const SimilarityCovariance units =
      unit_covariance(keyframe) + this_from_to * unit_covariance(place) * this_from_to.transpose();
  pack_covariance(map * covariance_of(link, keyframe, place) * map.transpose() + units, world.covariance);
  pack_covariance(units, world.unit_covariance);
  return world;
}

LoopError loop_error(const LinkRecord& link, const PoseRecord& keyframe, const PoseRecord& place) {
  const Similarity by_poses = compose(camera_of(keyframe), inverse(camera_of(place)));
  return {step_between(by_poses, similarity_of(link)), covariance_of(link, keyframe, place)};
}

bool has_covariance(const PoseRecord& pose) {
  return std::any_of(std::begin(pose.covariance), std::end(pose.covariance), [](double value) { return value != 0; });
}

Eigen::Matrix<double, 3, 7> ground_by_step(double distance) {
  return change_by_step(Vec3(0, 0, distance));
}

double error_of_link_at(const LinkRecord& link, const Vec3& point) {
  const Eigen::Matrix<double, 3, 7> moved = change_by_step(point);
  const Mat3 error = moved * unpack_covariance(link.covariance) * moved.transpose();
  return std::sqrt(error.trace());
}

double ground_error_of_poses(const PoseRecord& keyframe, const PoseRecord& place, double distance) {
  const Similarity keyframe_from_place = compose(camera_of(keyframe), inverse(camera_of(place)));
  const SimilarityCovariance covariance = covariance_of(keyframe_from_place, keyframe, place);
  const Eigen::Matrix<double, 3, 6> moved = ground_by_step(distance).leftCols<6>();
  const Mat3 error = moved * covariance.topLeftCorner<6, 6>() * moved.transpose();
  return std::sqrt(error.trace()) / distance;
}

}  // namespace ilp
