// The newest keyframes of a synthetic flight as an adjusted window of bundle adjustment, as the flight would have it if
// it took its camera's intrinsics for the given ones.
#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/Dense>

#include "fsw/vision/geometry/rigid_transform.hpp"
#include "fsw/vision/multiview/bundle/bundle_adjustment.hpp"
#include "tests/unit/vision/calibration/synthetic_flight.hpp"

namespace ilp::test {

class PosedWindow {
 public:
  /// Starts at the true poses; the first camera is fixed and the distance of the last from it held.
  PosedWindow(const SyntheticFlight& flight, const CameraModel& given) {
    const std::size_t views = std::min(flight.keyframes.size(), limits::max_window_keyframes);
    const std::size_t first = flight.keyframes.size() - views;
    for (std::size_t i = 0; i < views; ++i) {
      const world::CameraState& truth = flight.keyframes[first + i].truth;
      const RigidTransform pose{truth.rotation, -(truth.rotation * truth.centre)};
      (void)problem_->cameras.push_back({pose_from(pose), given.fx, given.fy, given.cx, given.cy, i == 0});
    }
    problem_->hold = {true, 0, static_cast<std::uint16_t>(views - 1)};
    add_tracks(flight, first, given);
    BundleParams params{.max_iterations = 60, .robust_px = 0.5};
    const auto adjuster = std::make_unique<BundleAdjuster>();
    ok_ = adjuster->run(*problem_, params, result_).ok();
  }
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] BundleProblem& problem() { return *problem_; }
  [[nodiscard]] const BundleProblem& problem() const { return *problem_; }
  [[nodiscard]] double rms_px() const { return result_.final_rms_px; }

 private:
  struct Ray {
    std::uint16_t camera;
    Corner corner;
  };

  void add_tracks(const SyntheticFlight& flight, std::size_t first, const CameraModel& given) {
    std::map<std::uint16_t, std::vector<Ray>> open;  // by corner of the newest view
    for (std::size_t k = first; k < flight.keyframes.size(); ++k) {
      const auto camera = static_cast<std::uint16_t>(k - first);
      std::map<std::uint16_t, std::vector<Ray>> next;
      const FlightKeyframe& frame = flight.keyframes[k];
      for (std::size_t i = 0; camera > 0 && i < frame.matches.size(); ++i) {
        const Match& m = frame.matches[i];
        std::vector<Ray> track = open[m.a];
        if (track.empty()) {
          track.push_back({static_cast<std::uint16_t>(camera - 1), flight.keyframes[k - 1].corners[m.a]});
        }
        open.erase(m.a);
        track.push_back({camera, frame.corners[m.b]});
        next[m.b] = track;
      }
      for (const auto& [corner, track] : open) add(track, given);
      open = next;
    }
    for (const auto& [corner, track] : open) add(track, given);
  }

  /// Adds the point that is nearest to all rays.
  void add(const std::vector<Ray>& track, const CameraModel& given) {
    if (track.size() < 2) return;
    Mat3 sum = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (const Ray& ray : track) {
      const RigidTransform world_from_camera = inverse(cam_from_world(problem_->cameras[ray.camera].pose));
      const Vec3 in_camera((ray.corner.x - given.cx) / given.fx, (ray.corner.y - given.cy) / given.fy, 1);
      const Vec3 direction = (world_from_camera.rotation * in_camera).normalized();
      const Mat3 across = Mat3::Identity() - direction * direction.transpose();
      sum += across;
      right += across * world_from_camera.translation;
    }
    const Vec3 x = sum.ldlt().solve(right);
    if (problem_->observations.size() + track.size() > problem_->observations.capacity() ||
        !problem_->points.push_back({{x.x(), x.y(), x.z()}})) {
      return;
    }
    for (const Ray& ray : track) {
      (void)problem_->observations.push_back(
          {ray.camera, static_cast<std::uint16_t>(problem_->points.size() - 1), ray.corner.x, ray.corner.y});
    }
  }

  std::unique_ptr<BundleProblem> problem_ = std::make_unique<BundleProblem>();
  BundleResult result_;
  bool ok_ = false;
};

}  // namespace ilp::test
