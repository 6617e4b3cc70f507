// Keyframes of a narrow camera about a small body that turns: strips, and keyframes without a pose between them, whose
// truth is known exactly. The focal length is nine times the image's width, so that the field is 6 degrees wide.
#pragma once

#include <Eigen/Cholesky>

#include "sim/host/statistics.hpp"
#include "tests/unit/ground/model/noisy_flight.hpp"

namespace ilp::model::test {

/// Keyframes in the order of their angles about the body: strips of three, and keyframes without a pose between them.
struct Course {
  int singles = 1;                  ///< between two strips
  double least = 0.3, most = 0.49;  ///< turn from one strip or single keyframe to the next, rad
  int linked_back = 1;              ///< each keyframe is linked with so many before it, of other strips
};

struct NarrowFlight : NoisyFlight {
  static constexpr double focal_px = 9 * 640, radius = 200 / focal_px, distance = 1;
  static constexpr double relief = 0.15, noise_of_match_px = 0.4;
  static constexpr std::size_t course_keyframes = 20;

  explicit NarrowFlight(std::uint64_t seed) {
    camera_ = camera_of_field(640, 480, 2 * std::atan(320 / focal_px));
    rng_ = Rng(seed);
    const double phase = 6 * rng_.uniform();
    for (int i = 0; i < 1500; ++i) {
      const Vec3 n = Vec3(gauss(), gauss(), gauss()).normalized();
      normals_.push_back(n);
      const double height = relief * std::sin(5 * n.x() + phase) * std::cos(4 * n.y() + 3 * n.z());
      surface_.push_back(radius * (1 + height) * n);
    }
  }

  /// Looks about at the body's middle, after the body has turned by this angle.
  RigidTransform about_body(double angle) {
    RigidTransform pose;
    const double away = 20 / focal_px;
    const Mat3 pointing = rotation_from_vector(Vec3(away * gauss(), away * gauss(), 0));
    pose.rotation =
        pointing * rotation_from_vector(Vec3(0.3, 0, 0.05 * gauss())) * rotation_from_vector(Vec3(0, angle, 0));
    pose.translation = pointing * Vec3(0, 0, distance);
    return pose;
  }

  [[nodiscard]] const RigidTransform& truth(std::int64_t id) const { return truth_[static_cast<std::size_t>(id - 1)]; }
  [[nodiscard]] static Vec3 centre(const RigidTransform& pose) {
    return -(pose.rotation.transpose() * pose.translation);
  }
  [[nodiscard]] bool shows(const RigidTransform& pose, std::size_t i, Vec2& px) {
    return normals_[i].dot(centre(pose).normalized()) > 0.25 && see(pose, surface_[i], px);
  }

  /// A strip of keyframes that the flight has posed, with four fifths of the body's points.
  void fly_strip(std::int64_t id, const std::vector<double>& angles, const Similarity& strip_from_truth) {
    std::vector<RigidTransform> poses;
    for (const double angle : angles) poses.push_back(about_body(angle));
    fly(id, poses, strip_from_truth, false);
    for (std::size_t i = 0; i < surface_.size(); ++i) {
      intake::StructureTrackPoint track;
      for (const std::int64_t key : strips_.back().keyframes) {
        Vec2 px;
        if (i % 5 == 0 || !shows(truth(key), i, px)) continue;
        px += noise_of_match_px * Vec2(gauss(), gauss());
        track.observations.push_back({key, static_cast<float>(px.x()), static_cast<float>(px.y())});
      }
      if (track.observations.size() < 2) continue;
      const Vec3 in_strip = strip_from_truth * surface_[i];
      std::copy_n(in_strip.data(), 3, track.point.position);
      track.point.observations = static_cast<std::uint32_t>(track.observations.size());
      flight_.keyframes[track.observations.back().keyframe_id].points.push_back(track);
    }
  }

  /// A strip of one keyframe, without a pose.
  void see_single(std::int64_t strip, double angle) {
    see_without_pose(static_cast<std::int64_t>(truth_.size()) + 1, about_body(angle), strip);
  }

  /// `count` matches on the body, and `on_edge` ones on its edge, which stays where it is when the body turns.
  void link_body(std::int64_t place, std::int64_t newer, int count, int on_edge) {
    LinkRecord record;
    record.keyframe_id = newer;
    record.place_id = place;
    record.strip_id = flight_.keyframes[newer].strip_id;
    record.place_strip_id = flight_.keyframes[place].strip_id;
    record.id = link_id(newer, links_of_[newer]++);
    std::vector<std::pair<Vec2, Vec2>> pairs;
    for (std::size_t i = 0; i < surface_.size(); ++i) {
      Vec2 in_a, in_b;
      if (shows(truth(place), i, in_a) && shows(truth(newer), i, in_b)) pairs.emplace_back(in_a, in_b);
    }
    if (pairs.size() < 12) return;
    put_plane(pairs, record);
    std::vector<LinkPoint>& points = flight_.link_points[record.id];
    const auto add = [&](const Vec2& in_a, const Vec2& exact) {
      const Vec2 in_b = exact + noise_of_match_px * Vec2(gauss(), gauss());
      points.push_back({unit(in_a.x()), unit(in_a.y()), unit(in_b.x()), unit(in_b.y())});
    };
    for (int i = 0; i < count; ++i) {
      const auto& [in_a, in_b] = pairs[rng_.below(static_cast<std::uint32_t>(pairs.size()))];
      add(in_a, in_b);
    }
    for (int i = 0; i < on_edge; ++i) {
      const double along = 6.2832 * rng_.uniform();
      const Vec3 on_circle = radius * Vec3(std::cos(along), std::sin(along), 0);
      RigidTransform a, b;
      a.translation = truth(place).translation;
      b.translation = truth(newer).translation;
      Vec2 in_a, in_b;
      if (see(a, on_circle, in_a) && see(b, on_circle, in_b)) add(in_a, in_b);
    }
    flight_.links.push_back(record);
  }

  /// The affine map that fits the points of both images best.
  static void put_plane(const std::vector<std::pair<Vec2, Vec2>>& pairs, LinkRecord& record) {
    Mat3 normal = Mat3::Zero();
    Eigen::Matrix<double, 3, 2> right = Eigen::Matrix<double, 3, 2>::Zero();
    for (const auto& [in_a, in_b] : pairs) {
      const Vec3 row(in_a.x(), in_a.y(), 1);
      normal += row * row.transpose();
      right += row * in_b.transpose();
    }
    const Eigen::Matrix<double, 3, 2> map = normal.ldlt().solve(right);
    for (int i = 0; i < 3; ++i) {
      record.keyframe_from_place_px[i] = map(i, 0);
      record.keyframe_from_place_px[3 + i] = map(i, 1);
      record.keyframe_from_place_px[6 + i] = i == 2 ? 1 : 0;
    }
  }

  /// `on_edge`: share of the matches that lie on the body's edge.
  void fly_course(const Course& course, double on_edge) {
    std::vector<double> angles;  // by keyframe
    double angle = 0;
    for (std::int64_t strip = 1; angles.size() < course_keyframes;) {
      const auto next_unit = [&] { angle += course.least + (course.most - course.least) * rng_.uniform(); };
      std::vector<double> of_strip;
      for (int i = 0; i < 3; ++i) {
        of_strip.push_back(angle);
        if (i < 2) angle += 0.09 + 0.06 * rng_.uniform();
      }
      next_unit();
      angles.insert(angles.end(), of_strip.begin(), of_strip.end());
      const auto number = static_cast<double>(strip);
      const Similarity world{rotation_from_vector(Vec3(0.1 * number, -0.2, 0.7)), Vec3(3, 1, -2), 5 + 0.1 * number};
      fly_strip(strip, of_strip, strip == 1 ? Similarity{} : world);
      ++strip;
      for (int i = 0; i < course.singles; ++i) {
        see_single(strip++, angle);
        angles.push_back(angle);
        next_unit();
      }
    }
    for (std::size_t k = 1; k < angles.size(); ++k) {
      for (std::size_t back = 1; back <= static_cast<std::size_t>(course.linked_back) && back <= k; ++back) {
        const double turn = angles[k] - angles[k - back];
        const auto newer = static_cast<std::int64_t>(k + 1), place = static_cast<std::int64_t>(k + 1 - back);
        if (turn > 0.5 || flight_.keyframes[newer].strip_id == flight_.keyframes[place].strip_id) continue;
        const double on_body = 60 * (1 - 1.6 * turn);
        link_body(place, newer, static_cast<int>(on_body), static_cast<int>(on_body * on_edge / (1 - on_edge)));
      }
    }
  }

  /// Of a camera in a model, in units of the model's extent, after the similarity that fits all of its cameras best.
  struct Placed {
    std::int64_t keyframe_id = 0;
    double error = 0;
    double sigma = 0;  ///< stated, with what is stated of the whole model: errors count from one of its cameras
  };
  std::vector<Placed> placed_in(const JoinedModel& model) {
    host::CameraTrack track, reference;
    std::vector<double> sigmas;
    for (const JoinedModel::Member& member : model.members) {
      const PoseRecord& record = *flight_.keyframes[member.keyframe_id].pose;
      const RigidTransform pose = cam_from_world(pose_of(record)), &exact = truth(member.keyframe_id);
      track.add(centre(pose), pose.rotation);
      reference.add(centre(exact), exact.rotation);
      sigmas.push_back(std::hypot(record.sigma[0], record.sigma[1], record.sigma[2]));
    }
    double extent = 0;
    for (const Vec3& a : reference.centres) {
      for (const Vec3& b : reference.centres) extent = std::max(extent, (a - b).norm());
    }
    const auto aligned =
        host::align_cameras(track.centres, track.cam_from_world, reference.centres, reference.cam_from_world, extent);
    const double of_model = host::median(sigmas);
    std::vector<Placed> placed;
    for (std::size_t i = 0; i < sigmas.size(); ++i) {
      placed.push_back({model.members[i].keyframe_id,
                        (*aligned * track.centres[i] - reference.centres[i]).norm() / extent,
                        aligned->scale * std::hypot(sigmas[i], of_model) / extent});
    }
    return placed;
  }

  std::vector<Vec3> surface_, normals_;
  std::map<std::int64_t, std::int64_t> links_of_;
};

}  // namespace ilp::model::test
