// Runs a synthetic strip through Sequence and compares what comes out with the truth.
#pragma once

#include <gtest/gtest.h>

#include "fsw/vision/multiview/sequence_workspace.hpp"
#include "tests/support/alignment.hpp"
#include "tests/unit/vision/multiview/synthetic_strip.hpp"

namespace ilp::test {

// Megabytes: static, as in flight.
inline SequenceState sequence_state;
inline SequenceWorkspace sequence_workspace;

/// What a consumer of the sequence collects.
struct Collected {
  std::vector<SequenceCamera> cameras;
  std::vector<FinalPoint> points;
  std::vector<SequenceReport> reports;
};

inline void collect(Sequence& sequence, Collected& out) {
  SequenceCamera camera;
  while (sequence.take_final_camera(camera)) out.cameras.push_back(camera);
  FinalPoint point;
  while (sequence.take_final_point(point)) out.points.push_back(point);
}

/// Ends the strip as the flight does.
inline void end(Sequence& sequence) {
  static_cast<void>(sequence.begin_with_best_pair());
  while (!sequence.idle()) ASSERT_TRUE(sequence.step().ok());
  ASSERT_TRUE(sequence.flush().ok());
}

inline Collected run(const SyntheticStrip& strip, const SequenceParams& params = {}) {
  Collected out;
  Sequence sequence(sequence_state, sequence_workspace);
  EXPECT_TRUE(sequence.begin_strip(strip.camera, params).ok());
  for (std::size_t k = 0; k < strip.keyframes.size(); ++k) {
    const test::StripKeyframe& frame = strip.keyframes[k];
    SequenceReport report;
    const Status status =
        sequence.add_keyframe(static_cast<std::int64_t>(100 + k), frame.corners, frame.matches, k, report);
    EXPECT_TRUE(status.ok()) << k << ": " << status_name(status.code) << " " << status.a << " " << status.b;
    out.reports.push_back(report);
    collect(sequence, out);
  }
  end(sequence);
  collect(sequence, out);
  return out;
}

struct Truth {
  std::vector<Eigen::Vector3d> estimated, actual;
  double length = 0;
};

inline Truth compare(const SyntheticStrip& strip, const Collected& out) {
  Truth truth;
  for (const SequenceCamera& camera : out.cameras) {
    const auto k = static_cast<std::size_t>(camera.keyframe_id - 100);
    truth.estimated.push_back(vector_of(camera.pose.centre));
    truth.actual.push_back(inverse(strip.keyframes[k].truth).translation);
    if (truth.actual.size() > 1) truth.length += (truth.actual.back() - truth.actual[truth.actual.size() - 2]).norm();
  }
  return truth;
}

/// Worst position error after similarity alignment, in per cent of the strip's length.
inline double worst_error_percent(const SyntheticStrip& strip, const Collected& out) {
  const Truth truth = compare(strip, out);
  const test::AlignmentErrors errors = test::alignment_errors(truth.estimated, truth.actual);
  ::testing::Test::RecordProperty("mean_percent", std::to_string(100 * errors.mean / truth.length));
  return 100 * errors.worst / truth.length;
}

}  // namespace ilp::test
