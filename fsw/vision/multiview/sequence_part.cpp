#include "fsw/vision/multiview/sequence_part.hpp"

#include <algorithm>

#include "fsw/base/median.hpp"
#include "fsw/base/rng.hpp"
#include "fsw/vision/geometry/rigid_transform.hpp"

namespace ilp {
namespace {

// Streams that separate the random numbers of one keyframe's searches; other parts have 2 to 6.
constexpr std::uint64_t two_view_stream = 1;

}  // namespace

void SequencePart::fail(SequenceVerdict verdict) {
  s_.report.verdict = verdict;
  s_.phase = SequencePhase::idle;
}

RansacParams SequencePart::two_view_params(std::uint64_t seed) const {
  RansacParams params = s_.params.two_view;
  params.seed = mix64(params.seed ^ mix64(seed ^ two_view_stream));
  return params;
}

ResectionParams SequencePart::resection_params(std::uint64_t seed) const {
  ResectionParams params;
  params.threshold_px = s_.params.resection_threshold_px;
  params.robust_px = s_.params.robust_px;
  params.seed = mix64(seed);
  return params;
}

void SequencePart::push_camera(const RigidTransform& pose, bool posed) {
  const std::size_t keep =
      std::min<std::size_t>(limits::max_bundle_cameras, s_.params.window_keyframes + limits::max_fixed_keyframes);
  if (s_.cameras.size() == keep) {
    s_.cameras.erase(0);
    ++s_.oldest;
    drop_oldest_camera(s_.covariance);
    for (Track& track : s_.tracks) s_.report.shortened_tracks += shorten(track, s_.oldest) ? 1 : 0;
  }
  SequenceCamera camera;
  camera.keyframe_id = s_.keyframe_id;
  camera.pose = pose_from(pose);
  camera.posed = posed;
  (void)s_.cameras.push_back(camera);  // there is room: keep is within the capacity
}

void SequencePart::scale_to_first_height() {
  if (!(s_.params.first_height > 0)) return;
  std::size_t count = 0;
  for (const Track& track : s_.tracks) {
    // At most max_matches tracks were begun. The first camera looks down: depth is minus z.
    if (track.phase == TrackPhase::point) w_.ratios[count++] = -track.position[2];
  }
  if (count == 0) return;
  const double scale = s_.params.first_height / upper_median(std::span(w_.ratios).first(count));
  for (std::size_t i = 1; i < s_.cameras.size(); ++i) {
    for (double& x : s_.cameras[i].pose.centre) x *= scale;
  }
  for (Track& track : s_.tracks) {
    for (double& x : track.position) x *= scale;
  }
}

}  // namespace ilp
