// A small body that turns before a camera of a narrow field of view: its focal length is nine times the image's width.
// Corners and matches with known truth, no images.
#pragma once

#include <unordered_map>

#include "tests/unit/vision/multiview/synthetic_strip.hpp"

namespace ilp::test {

struct NarrowScene {
  int keyframes = 12;
  double least_turn = 0.09, most_turn = 0.49;  ///< of the body from image to image, rad
  double relief = 0.1;                         ///< of the body, share of its radius
  double radius_px = 200;                      ///< of the body in the image
  double pointing_px = 20;                     ///< standard deviation of the body's place in the image
  double noise_px = 0.2;
  double wrong = 0.1;      ///< share of matches that join different corners
  int at_edge = 0;         ///< matches along the edge of the body, which stays where it is when the body turns
  double kept_after = 1;   ///< share of the matches that are left after a turn of half a radian
  int corners = 500;       ///< of the body in an image
  double focal_px = 5760;  ///< the larger, the more parallel the rays to the body
  unsigned seed = 1;
};

/// Flies around the body, whose centre is the origin and whose distance is 1.
class NarrowFlight {
 public:
  explicit NarrowFlight(const NarrowScene& scene) : scene_(scene), random_(scene.seed) {
    strip_.keyframes.clear();
    strip_.camera = CameraModel{640, 480, scene.focal_px, scene.focal_px, 320, 240, 0, 0, 0, 0};
    radius_ = scene.radius_px / scene.focal_px;
    make_surface();
    double angle = 0, turn = 0;
    for (int k = 0; k < scene.keyframes; ++k) {
      take(angle, turn);
      turn = scene.least_turn + (scene.most_turn - scene.least_turn) * uniform_(random_);
      angle += turn;
    }
  }

  [[nodiscard]] const SyntheticStrip& strip() const { return strip_; }

 private:
  struct SurfacePoint {
    Vec3 place, normal;
  };

  void make_surface() {
    const double phase = 6 * uniform_(random_);
    while (surface_.size() < static_cast<std::size_t>(3 * scene_.corners)) {
      const Vec3 n = Vec3(normal_(random_), normal_(random_), normal_(random_)).normalized();
      const double bump = 1 + scene_.relief * std::sin(5 * n.x() + phase) * std::cos(4 * n.y() + 3 * n.z());
      surface_.push_back({radius_ * bump * n, n});
    }
  }

  /// The keyframe after the body has turned to `angle`, by `turn` since the one before.
  void take(double angle, double turn) {
    StripKeyframe frame;
    const Mat3 towards = rotation_from_vector(Vec3(0, 0, 0.05 * normal_(random_))) *
                         rotation_from_vector(Vec3(0.3 + 0.02 * normal_(random_), 0, 0)) *
                         rotation_from_vector(Vec3(0, angle, 0));
    const double away = scene_.pointing_px / scene_.focal_px;
    const Mat3 pointing = rotation_from_vector(Vec3(away * normal_(random_), away * normal_(random_), 0));
    frame.truth = {pointing * towards, pointing * Vec3(0, 0, 1)};
    seen_.clear();
    matches_.clear();
    const double kept = 1 - (1 - scene_.kept_after) * std::min(1.0, turn / 0.5);
    const Vec3 view = towards.transpose() * Vec3(0, 0, -1);
    for (std::size_t i = 0; i < surface_.size(); ++i) {
      if (surface_[i].normal.dot(view) < 0.25) continue;
      const Corner corner = project(frame, surface_[i].place);
      add(i, corner, uniform_(random_) < kept, frame);
    }
    for (int i = 0; i < scene_.at_edge; ++i) {
      const double along = 2 * pi * i / scene_.at_edge;
      const Vec3 across = towards.transpose() * Vec3(std::cos(along), std::sin(along), 0);
      add(surface_.size() + static_cast<std::size_t>(i), project(frame, radius_ * across), true, frame);
    }
    finish_matches(frame);
    previous_ = seen_;
    strip_.keyframes.push_back(frame);
  }

  Corner project(const StripKeyframe& frame, const Vec3& place) {
    const Vec3 x = frame.truth * place;
    const Vec2 pixel = pixel_from_normalised(strip_.camera, Vec2(x.x() / x.z(), x.y() / x.z()));
    const double dx = scene_.noise_px * normal_(random_);
    const double dy = scene_.noise_px * normal_(random_);
    return {static_cast<float>(pixel.x() + dx), static_cast<float>(pixel.y() + dy), 1};
  }

  void add(std::size_t id, const Corner& at, bool matched, StripKeyframe& frame) {
    if (at.x < 8 || at.y < 8 || at.x > 631 || at.y > 471 || frame.corners.full()) return;
    const auto index = static_cast<std::uint16_t>(frame.corners.size());
    seen_[id] = index;
    (void)frame.corners.push_back(at);
    const auto found = previous_.find(id);
    if (found != previous_.end() && matched) matches_.push_back({found->second, index, 0.9F, at.x, at.y});
  }

  void finish_matches(StripKeyframe& frame) {
    std::vector<std::size_t> wrong;
    for (std::size_t i = 0; i < matches_.size(); ++i) {
      if (uniform_(random_) < scene_.wrong) wrong.push_back(i);
    }
    for (std::size_t i = 1; i < wrong.size(); ++i) std::swap(matches_[wrong[i - 1]].b, matches_[wrong[i]].b);
    std::sort(matches_.begin(), matches_.end(), [](const Match& a, const Match& b) { return a.a < b.a; });
    for (Match& m : matches_) {
      m.xb = frame.corners[m.b].x;
      m.yb = frame.corners[m.b].y;
      (void)frame.matches.push_back(m);
    }
  }

  NarrowScene scene_;
  std::mt19937 random_;
  std::uniform_real_distribution<double> uniform_{0, 1};
  std::normal_distribution<double> normal_{0, 1};
  double radius_ = 0;
  std::vector<SurfacePoint> surface_;
  std::unordered_map<std::size_t, std::uint16_t> previous_, seen_;
  std::vector<Match> matches_;
  SyntheticStrip strip_{StripScene{.keyframes = 1}};
};

}  // namespace ilp::test
