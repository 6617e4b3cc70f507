// Strips over a rolling ground whose cameras, points and sightings are known exactly, but for noise of the sightings.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/camera.hpp"
#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/joined_model.hpp"
#include "sim/host/alignment.hpp"

namespace ilp::model::test {

inline constexpr double flying_height = 10, noise_px = 0.05;

inline double ground(double x, double y) {
  return 0.4 * std::sin(0.5 * x) * std::cos(0.4 * y);
}

/// Looks down from (x, y, height), turned about the vertical.
inline RigidTransform looking_down(double x, double y, double turn_rad, double height = flying_height) {
  Mat3 down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  RigidTransform pose;
  pose.rotation = rotation_from_vector(Vec3(0.02, -0.03, 0)) * down * rotation_from_vector(Vec3(0, 0, turn_rad));
  pose.translation = -(pose.rotation * Vec3(x, y, height));
  return pose;
}

/// The flight's poses and points of one strip, in its own world.
struct StripTruth {
  std::int64_t id = 0;
  std::vector<std::int64_t> keyframes;
  Similarity strip_from_truth;
};

struct NoisyFlight {
  void fly(std::int64_t id, const std::vector<RigidTransform>& poses, const Similarity& strip_from_truth,
           bool over_ground = true) {
    StripTruth strip{id, {}, strip_from_truth};
    for (const RigidTransform& pose : poses) {
      const auto number = static_cast<std::int64_t>(truth_.size()) + 1;
      truth_.push_back(pose);
      strip.keyframes.push_back(number);
      intake::Keyframe& keyframe = flight_.keyframes[number];
      keyframe.id = number;
      keyframe.strip_id = id;
      keyframe.camera = camera_;
      PoseRecord record{.id = number, .strip_id = id, .state = PoseState::final};
      put_pose(strip_from_truth, pose, record);
      keyframe.pose = record;
      flight_.strips[id].id = id;
      flight_.strips[id].keyframes.push_back(number);
    }
    if (over_ground) add_points(strip);
    strips_.push_back(strip);
  }

  static void put_pose(const Similarity& strip_from_truth, const RigidTransform& pose, PoseRecord& record) {
    RigidTransform in_strip;
    const Vec3 centre = strip_from_truth * Vec3(-(pose.rotation.transpose() * pose.translation));
    in_strip.rotation = pose.rotation * strip_from_truth.rotation.transpose();
    in_strip.translation = -(in_strip.rotation * centre);
    const Pose written = pose_from(in_strip);
    std::copy_n(written.q_cam_from_world, 4, record.q_cam_from_world);
    std::copy_n(written.centre, 3, record.centre);
  }

  bool see(const RigidTransform& pose, const Vec3& point, Vec2& px) {
    const Vec3 p = pose * point;
    if (!(p.z() > 0)) return false;
    px = Vec2(camera_.fx * p.x() / p.z() + camera_.cx, camera_.fy * p.y() / p.z() + camera_.cy);
    return px.x() > 8 && px.y() > 8 && px.x() < 631 && px.y() < 471;
  }

  /// One sigma is 1.
  double gauss() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += rng_.uniform();
    return sum;
  }
  Vec2 noise() { return noise_px * Vec2(gauss(), gauss()); }

  /// Each image is bent in its own way, by `bend_px` (root mean square of each axis), the same for all points in one
  /// place.
  [[nodiscard]] Vec2 bend(std::int64_t id, const Vec2& px) const {
    const double phase = static_cast<double>(id) + bend_phase;
    const Vec2 radius = (px - Vec2(camera_.cx, camera_.cy)) / camera_.cx;
    return radial_px * radius.squaredNorm() * radius +
           2 * bend_px *
               Vec2(std::sin(px.x() / 45 + 2.4 * phase) * std::cos(px.y() / 200 + phase),
                    std::sin(px.y() / 40 + 1.7 * phase) * std::cos(px.x() / 200 + 2 * phase));
  }

  /// Points of a grid. As in a flight, a point is followed from keyframe to keyframe: where it comes back into view, it
  /// is another one.
  void add_points(const StripTruth& strip) {
    constexpr double reach = 8;
    std::map<std::pair<int, int>, std::vector<intake::StructureTrackPoint>> tracks;
    const auto on_grid = [&](double c) { return static_cast<int>(std::lround(c / grid_spacing)); };
    for (const std::int64_t id : strip.keyframes) {
      const RigidTransform& pose = truth_[static_cast<std::size_t>(id - 1)];
      const Vec3 below = -(pose.rotation.transpose() * pose.translation);
      for (int i = on_grid(below.x() - reach); i <= on_grid(below.x() + reach); ++i) {
        for (int j = on_grid(below.y() - reach); j <= on_grid(below.y() + reach); ++j) {
          Vec2 px;
          if (!see(pose, grid_point(i, j), px)) continue;
          px += noise() + bend(id, px);
          std::vector<intake::StructureTrackPoint>& of_point = tracks[{i, j}];
          if (of_point.empty() || of_point.back().observations.back().keyframe_id + 1 < id) of_point.emplace_back();
          of_point.back().observations.push_back({id, static_cast<float>(px.x()), static_cast<float>(px.y())});
        }
      }
    }
    for (auto& [place, of_point] : tracks) {
      for (intake::StructureTrackPoint& track : of_point) {
        if (track.observations.size() < 2) continue;
        const Vec3 in_strip = strip.strip_from_truth * grid_point(place.first, place.second);
        std::copy_n(in_strip.data(), 3, track.point.position);
        track.point.observations = static_cast<std::uint32_t>(track.observations.size());
        flight_.keyframes[track.observations.back().keyframe_id].points.push_back(track);
      }
    }
  }
  static constexpr double grid_spacing = 0.55;
  static Vec3 grid_point(int i, int j) {
    const double y = grid_spacing * j, x = grid_spacing * i + 0.2 * std::sin(7 * y);
    return {x, y, ground(x, y)};
  }

  /// What the flight sends of two keyframes that see the same ground: the plane's homography, and points.
  void link(std::int64_t place, std::int64_t newer, bool with_points = true, double error_px = 0) {
    LinkRecord record;
    record.id = link_id(newer, static_cast<std::int64_t>(flight_.links.size()) % limits::max_links_per_keyframe);
    record.keyframe_id = newer;
    record.place_id = place;
    record.strip_id = flight_.keyframes[newer].strip_id;
    record.place_strip_id = flight_.keyframes[place].strip_id;
    const RigidTransform &a = truth_[static_cast<std::size_t>(place - 1)],
                         &b = truth_[static_cast<std::size_t>(newer - 1)];
    const RigidTransform b_from_a = compose(b, inverse(a));
    const Vec3 normal = a.rotation * Vec3(0, 0, 1);  // plane z = 0: normal . (x - a * 0) = 0
    const double distance = normal.dot(a.translation);
    Mat3 k = Mat3::Identity();
    k(0, 0) = camera_.fx;
    k(1, 1) = camera_.fy;
    k(0, 2) = camera_.cx;
    k(1, 2) = camera_.cy;
    Mat3 h = k * (b_from_a.rotation + b_from_a.translation * normal.transpose() / distance) * k.inverse();
    h /= h(2, 2);
    for (int i = 0; i < 9; ++i) record.keyframe_from_place_px[i] = h(i / 3, i % 3);
    std::vector<LinkPoint>& points = flight_.link_points[record.id];
    for (int i = 0; with_points && i < 100; ++i) {
      const Vec3 below = -(a.rotation.transpose() * a.translation);
      const double x = below.x() + 12 * rng_.uniform() - 6, y = below.y() + 12 * rng_.uniform() - 6;
      const Vec3 point(x, y, ground(x, y));
      Vec2 in_a, in_b;
      if (!see(a, point, in_a) || !see(b, point, in_b)) continue;
      in_a += bend(place, in_a);
      in_b += noise() + error_px * Vec2(gauss(), gauss()) + bend(newer, in_b);
      points.push_back({unit(in_a.x()), unit(in_a.y()), unit(in_b.x()), unit(in_b.y())});
    }
    flight_.links.push_back(record);
  }
  static std::uint16_t unit(double px) {
    return static_cast<std::uint16_t>(std::clamp(std::lround(px * link_points_per_px), 0L, 65535L));
  }

  /// Moves the camera centres and the points of each keyframe by a similarity, as a flight that drifts states them.
  template <typename ByKeyframe>
  void drift(ByKeyframe drifted) {
    for (auto& [id, keyframe] : flight_.keyframes) {
      const Similarity by = drifted(id);
      const auto move = [&](double(&c)[3]) {
        const Vec3 moved = by * Vec3(c[0], c[1], c[2]);
        std::copy_n(moved.data(), 3, c);
      };
      move(keyframe.pose->centre);
      for (intake::StructureTrackPoint& track : keyframe.points) move(track.point.position);
    }
  }

  /// Lanes of one strip beside each other, there and back. Each keyframe has links to two of the lane before.
  void fly_lanes(int lanes, int per_lane) {
    std::vector<RigidTransform> poses;
    for (int lane = 0; lane < lanes; ++lane) {
      const bool back = lane % 2 == 1;
      for (int i = 0; i < per_lane; ++i)
        poses.push_back(looking_down(2.5 * (back ? per_lane - 1 - i : i), 5.0 * lane, back ? 3.1 : 0));
    }
    fly(1, poses, Similarity{});
    for (int lane = 1; lane < lanes; ++lane) {
      for (int i = 0; i < per_lane; ++i) {
        const int abreast = lane * per_lane - 1 - i;
        for (const int place : {abreast - 1, abreast}) {
          const bool chained = lane * per_lane + i - place <= 8;  // as on board
          if (!chained && place >= (lane - 1) * per_lane) link(place + 1, lane * per_lane + i + 1);
        }
      }
    }
  }

  /// Lanes beside each other, there and back, each a strip in a world of its own. Each keyframe has links to two of
  /// the lane before.
  void fly_strips(int strips, int per_strip) {
    for (int lane = 0; lane < strips; ++lane) {
      const bool back = lane % 2 == 1;
      std::vector<RigidTransform> poses;
      for (int i = 0; i < per_strip; ++i)
        poses.push_back(looking_down(2.5 * (back ? per_strip - 1 - i : i), 4.0 * lane, back ? 3.1 : 0));
      const Similarity world{rotation_from_vector(Vec3(0.1 * lane, -0.2, 0.7)), Vec3(3, lane, -2), 1 + 0.1 * lane};
      fly(lane + 1, poses, lane == 0 ? Similarity{} : world);
    }
    for (int lane = 1; lane < strips; ++lane) {
      for (int i = 0; i < per_strip; ++i) {
        link(lane * per_strip - i, lane * per_strip + i + 1);
        if (i + 1 < per_strip) link(lane * per_strip - i - 1, lane * per_strip + i + 1);
      }
    }
  }

  /// The flight as it came down before its last keyframe did.
  [[nodiscard]] intake::Flight without_last() const {
    intake::Flight flight = flight_;
    const std::int64_t last = flight.keyframes.rbegin()->first;
    for (intake::StructureTrackPoint track : flight.keyframes.at(last).points) {
      std::erase_if(track.observations, [&](const StructureObservation& seen) { return seen.keyframe_id == last; });
      track.point.observations = static_cast<std::uint32_t>(track.observations.size());
      if (track.observations.size() > 1)
        flight.keyframes.at(track.observations.back().keyframe_id).points.push_back(track);
    }
    std::erase_if(flight.links, [&](const LinkRecord& link) { return link.keyframe_id == last; });
    std::erase(flight.strips.at(flight.keyframes.at(last).strip_id).keyframes, last);
    flight.keyframes.erase(last);
    return flight;
  }

  /// Moves centres as a flight does that measures its scale a little wrongly, now too long, now too short.
  void drift_in_scale() {
    drift([](std::int64_t id) {
      return Similarity{Mat3::Identity(), Vec3::Zero(), 1 + 0.002 * std::sin(0.065 * static_cast<double>(id))};
    });
  }

  /// Root mean square of the distances of the cameras of a joined flight from where they were, after the similarity
  /// that fits them best, as a share of the flying height.
  [[nodiscard]] double rms_error(const intake::Flight& joined) const {
    std::vector<Vec3> centres, truth;
    for (const auto& [id, keyframe] : joined.keyframes) {
      const double(&c)[3] = keyframe.pose->centre;
      const RigidTransform& pose = truth_[static_cast<std::size_t>(id - 1)];
      centres.emplace_back(c[0], c[1], c[2]);
      truth.emplace_back(-(pose.rotation.transpose() * pose.translation));
    }
    const auto aligned = host::align_positions(centres, truth);
    double squares = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) squares += (*aligned * centres[i] - truth[i]).squaredNorm();
    return std::sqrt(squares / static_cast<double>(truth.size())) / flying_height;
  }

  JoinedFlight join() {
    return join_strips(flight_, [](const std::string&) {});
  }

  /// Largest distance of a camera from where it was, in the world of `strip`, as a share of the flying height.
  double position_error(const Similarity& strip_from_truth, const std::vector<std::int64_t>& keyframes) {
    double largest = 0;
    for (const std::int64_t id : keyframes) {
      const RigidTransform& pose = truth_[static_cast<std::size_t>(id - 1)];
      const double(&c)[3] = flight_.keyframes[id].pose->centre;
      const Vec3 centre = strip_from_truth * Vec3(-(pose.rotation.transpose() * pose.translation));
      largest = std::max(largest, (Vec3(c[0], c[1], c[2]) - centre).norm() / (strip_from_truth.scale * flying_height));
    }
    return largest;
  }

  void fly_two_lanes(int keyframes = 5) {
    std::vector<RigidTransform> lane, back;
    for (int i = 0; i < keyframes; ++i) {
      lane.push_back(looking_down(2.5 * i, 0, 0));
      back.push_back(looking_down(2.5 * (keyframes - 1 - i), 3, 3.0));
    }
    fly(1, lane, Similarity{});
    fly(2, back, second_);
  }

  /// A strip of one keyframe. Only its image would make it a view: an empty product stands for one that does not
  /// decode.
  void see_without_pose(std::int64_t id, const RigidTransform& pose, std::int64_t strip = 3) {
    truth_.push_back(pose);
    intake::Keyframe& keyframe = flight_.keyframes[id];
    keyframe.id = id;
    keyframe.strip_id = strip;
    keyframe.camera = camera_;
    flight_.strips[strip].id = strip;
    flight_.strips[strip].keyframes.push_back(id);
    keyframe.product_files[static_cast<std::size_t>(ProductKind::image)] = {0};
  }

  CameraModel camera_ = camera_of_field(640, 480, 2 * std::atan(320 / 600.0));
  Similarity second_{rotation_from_vector(Vec3(0.1, -0.2, 0.7)), Vec3(3, 1, -2), 1.7};
  intake::Flight flight_;
  std::vector<RigidTransform> truth_;  ///< by keyframe
  std::vector<StripTruth> strips_;
  double bend_px = 0, bend_phase = 0;
  double radial_px = 0;  ///< of all images, at the end of a row: a lens that is not known well
  Rng rng_{7};
};

}  // namespace ilp::model::test
