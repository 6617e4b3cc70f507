// Recorded flights, from images to final cameras, against reference cameras computed by other software from more and
// larger images. Corners, predictions and matches are our own, as in flight.
#include <gtest/gtest.h>

#include <memory>

#include "fsw/vision/features/harris_workspace.hpp"
#include "fsw/vision/features/matcher_workspace.hpp"
#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "fsw/vision/overlap/overlap_workspace.hpp"
#include "tests/support/alignment.hpp"
#include "tests/support/strip.hpp"

namespace ilp {
namespace {

struct RecordedStrip {
  const char* folder;
  std::size_t segments;  ///< contiguous strips: where the overlap is below what resection can bridge, a new one begins
  std::size_t relative;  ///< keyframes that are part of a piece of three or more
  double worst_percent;  ///< of the length of a piece
};

class SequenceOfStrip : public testing::TestWithParam<RecordedStrip> {
 protected:
  struct Segment {
    std::vector<Eigen::Vector3d> estimated, reference;
  };

  /// Corners and matches to the newest posed keyframe.
  void match(const test::Image& previous, const test::Image& image) {
    ASSERT_TRUE(detect_corners(image.view(), {}, *harris_workspace_, corners_).ok());
    matches_.clear();
    if (previous.empty()) return;
    OverlapParams params{.min_overlap = 0.35};
    OverlapResult overlap;
    ASSERT_TRUE(measure_overlap(previous.view(), image.view(), params, *overlap_workspace_, overlap).ok());
    overlap_ = overlap.overlap;
    ASSERT_TRUE(match_corners_by_plane(previous.view(), state_->corners, image.view(), corners_, overlap.plane_b_from_a,
                                       {}, *matcher_workspace_, matches_)
                    .ok());
  }

  void collect(const std::vector<test::StripImage>& images) {
    SequenceCamera camera;
    while (sequence_.take_final_camera(camera)) {
      const double* c = camera.pose.centre;
      segments_.back().estimated.emplace_back(c[0], c[1], c[2]);
      const double* r = images[static_cast<std::size_t>(camera.keyframe_id)].centre;
      segments_.back().reference.emplace_back(r[0], r[1], r[2]);
    }
    FinalPoint point;
    while (sequence_.take_final_point(point)) EXPECT_GE(point.observations.size(), 2U);
  }

  void begin_segment(const CameraModel& camera) {
    SequenceParams params;
    // Nothing is tracked here as it is in flight: across an overlap of 0.39 too few known points are left within 1 px.
    params.resection_threshold_px = 1.5;
    ASSERT_TRUE(sequence_.begin_strip(camera, params).ok());
    segments_.emplace_back();
  }

  std::unique_ptr<OverlapWorkspace> overlap_workspace_ = std::make_unique<OverlapWorkspace>();
  std::unique_ptr<HarrisWorkspace> harris_workspace_ = std::make_unique<HarrisWorkspace>();
  std::unique_ptr<MatcherWorkspace> matcher_workspace_ = std::make_unique<MatcherWorkspace>();
  std::unique_ptr<SequenceState> state_ = std::make_unique<SequenceState>();
  std::unique_ptr<SequenceWorkspace> workspace_ = std::make_unique<SequenceWorkspace>();
  Sequence sequence_{*state_, *workspace_};
  Corners corners_;
  Matches matches_;
  double overlap_ = 0;
  std::vector<Segment> segments_;
};

TEST_P(SequenceOfStrip, AgreesWithTheReferenceCameras) {
  const std::string folder = GetParam().folder;
  const auto images = test::read_strip(folder);
  if (images.empty()) GTEST_SKIP() << "no data in " << test::data_root << folder;
  begin_segment(images[0].camera);
  test::Image previous;
  for (std::size_t k = 0; k < images.size(); ++k) {
    const test::Image image = test::read_strip_image(folder, images[k].name);
    match(previous, image);
    SequenceReport report;
    ASSERT_TRUE(sequence_.add_keyframe(static_cast<std::int64_t>(k), corners_, matches_, k, report).ok());
    std::printf(
        "%s %s: %s, overlap %.2f, %u matches, %u inliers, %u resected, %u points, rms %.3f px, scale step %.4f\n",
        folder.c_str(), images[k].name.c_str(), name_of(report.verdict), overlap_, report.matches,
        report.two_view.inliers, report.resection_inliers, report.points, report.rms_px, report.scale_step);
    if (report.verdict != SequenceVerdict::ok && report.verdict != SequenceVerdict::waiting) {
      ASSERT_TRUE(sequence_.flush().ok());
      collect(images);
      begin_segment(images[k].camera);
      ASSERT_TRUE(sequence_.add_keyframe(static_cast<std::int64_t>(k), corners_, {}, k, report).ok());
    }
    collect(images);
    previous = image;
  }
  ASSERT_TRUE(sequence_.flush().ok());
  collect(images);

  std::size_t relative = 0;
  for (const Segment& segment : segments_) {
    if (segment.reference.size() < 3) continue;
    relative += segment.reference.size();
    double length = 0;
    for (std::size_t k = 1; k < segment.reference.size(); ++k) {
      length += (segment.reference[k] - segment.reference[k - 1]).norm();
    }
    const test::AlignmentErrors errors = test::alignment_errors(segment.estimated, segment.reference);
    std::printf("%s: %zu cameras, position error mean %.3f %%, worst %.3f %% of the length\n", folder.c_str(),
                segment.reference.size(), 100 * errors.mean / length, 100 * errors.worst / length);
    EXPECT_LT(100 * errors.worst / length, GetParam().worst_percent);
  }
  EXPECT_LE(segments_.size(), GetParam().segments);
  EXPECT_GE(relative, GetParam().relative);
}

INSTANTIATE_TEST_SUITE_P(Recorded, SequenceOfStrip,
                         testing::Values(RecordedStrip{"aerial_caliterra_a", 1, 7, 0.2},
                                         RecordedStrip{"aerial_caliterra_climb", 1, 7, 0.2},
                                         RecordedStrip{"aerial_coal_oil_point", 2, 21, 0.2}),
                         [](const auto& tested) { return std::string(tested.param.folder); });

}  // namespace
}  // namespace ilp
