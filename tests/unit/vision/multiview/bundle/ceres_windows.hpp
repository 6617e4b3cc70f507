// Windows of recorded strips, as the adjustment meets them in flight: our corners and matches, resected cameras, points
// just triangulated.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "fsw/vision/multiview/window_problem.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/strip.hpp"

namespace ilp::test {

inline constexpr const char* recorded_strips[] = {"aerial_caliterra_a", "aerial_caliterra_climb",
                                                  "aerial_coal_oil_point", "strecha_entry_p10", "strecha_fountain_p11"};

class RecordedWindows {
 public:
  /// Before its adjustment, each window of `min_cameras` or more; none when the data are absent. A scale that the
  /// flight would hold is fixed by a second camera instead.
  explicit RecordedWindows(const std::string& folder, std::size_t min_cameras = 4) : min_cameras_(min_cameras) {
    const std::vector<StripImage> images = read_strip(folder);
    Image previous;
    for (std::size_t k = 0; k < images.size(); ++k) {
      const Image image = read_strip_image(folder, images[k].name);
      if (k == 0 || !add(previous, image, k)) begin(images[k].camera, image, k);
      previous = image;
    }
  }

  [[nodiscard]] const std::vector<std::unique_ptr<BundleProblem>>& windows() const { return windows_; }

 private:
  /// A new piece of the strip, from this image on.
  void begin(const CameraModel& camera, const Image& image, std::size_t k) {
    good_ = sequence_.begin_strip(camera, {}).ok() && detect_corners(image.view(), {}, *harris_, corners_).ok();
    matches_.clear();
    relate(k);
  }

  /// False when the image cannot be related to the previous image.
  bool add(const Image& previous, const Image& image, std::size_t k) {
    OverlapParams params{.min_overlap = 0.35};
    OverlapResult overlap;
    good_ = good_ && detect_corners(image.view(), {}, *harris_, corners_).ok() &&
            measure_overlap(previous.view(), image.view(), params, *overlap_, overlap).ok() &&
            match_corners_by_plane(previous.view(), state_->corners, image.view(), corners_, overlap.plane_b_from_a, {},
                                   *matcher_, matches_)
                .ok();
    relate(k);
    return good_ && sequence_.report().verdict == SequenceVerdict::ok;
  }

  void relate(std::size_t k) {
    good_ = good_ && sequence_.begin_keyframe(static_cast<std::int64_t>(k), corners_, matches_, k).ok();
    while (good_ && !sequence_.idle()) {
      if (state_->phase == SequencePhase::adjust && !state_->adjusting) keep_window();
      good_ = sequence_.step().ok();
    }
    SequenceCamera camera;
    FinalPoint point;
    while (sequence_.take_final_camera(camera)) continue;
    while (sequence_.take_final_point(point)) continue;
  }

  void keep_window() {
    auto problem = std::make_unique<BundleProblem>();
    build_window(*state_, *problem, workspace_->map);
    if (problem->cameras.size() < min_cameras_) return;
    if (problem->hold.held) problem->cameras[problem->hold.anchor].fixed = true;
    problem->hold = {};
    windows_.push_back(std::move(problem));
  }

  std::unique_ptr<OverlapWorkspace> overlap_ = std::make_unique<OverlapWorkspace>();
  std::unique_ptr<HarrisWorkspace> harris_ = std::make_unique<HarrisWorkspace>();
  std::unique_ptr<MatcherWorkspace> matcher_ = std::make_unique<MatcherWorkspace>();
  std::unique_ptr<SequenceState> state_ = std::make_unique<SequenceState>();
  std::unique_ptr<SequenceWorkspace> workspace_ = std::make_unique<SequenceWorkspace>();
  Sequence sequence_{*state_, *workspace_};
  Corners corners_;
  Matches matches_;
  std::size_t min_cameras_;
  bool good_ = true;
  std::vector<std::unique_ptr<BundleProblem>> windows_;
};

}  // namespace ilp::test
