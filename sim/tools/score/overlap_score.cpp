#include "sim/tools/score/overlap_score.hpp"

#include <cmath>
#include <map>

#include "sim/host/files.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::score {
namespace {

std::map<std::int64_t, std::string> names_of_frames(const intake::Flight& flight) {
  std::map<std::int64_t, std::string> names;
  for (const auto& [id, frame] : flight.frames) names[id] = host::safe_name(frame.name);
  for (const auto& [id, keyframe] : flight.keyframes) {
    if (keyframe.record) names[keyframe.record->frame_id] = keyframe.name;
  }
  return names;
}

void measure(const intake::Flight& flight, TrueFrames& truth, OverlapScore& score) {
  const std::map<std::int64_t, std::string> names = names_of_frames(flight);
  for (const auto& [frame_id, overlap] : flight.overlaps) {
    const auto keyframe = flight.keyframes.find(overlap.keyframe_id);
    const auto name = names.find(frame_id);
    if (overlap.verdict != OverlapVerdict::ok || keyframe == flight.keyframes.end() || name == names.end()) continue;
    if (keyframe->second.name == name->second) continue;  // the first of a strip is compared with nothing
    const world::TrueFrame* a = truth.sampled(keyframe->second.name);
    const world::TrueFrame* b = truth.sampled(name->second);
    if (a == nullptr || b == nullptr) continue;
    score.measured.push_back({keyframe->second.name, name->second, overlap.overlap,
                              world::true_footprint_overlap(*a, *b), world::true_overlap(*a, *b)});
  }
}

void achieve(const intake::Flight& flight, TrueFrames& truth, OverlapScore& score) {
  for (const auto& [strip_id, strip] : flight.strips) {
    for (std::size_t k = 1; k < strip.keyframes.size(); ++k) {
      const std::int64_t previous = strip.keyframes[k - 1], id = strip.keyframes[k];
      if (previous + 1 != id) continue;  // what came down is not the whole strip
      const world::TrueFrame* a = truth.sampled(flight.keyframes.at(previous).name);
      const world::TrueFrame* b = truth.sampled(flight.keyframes.at(id).name);
      if (a != nullptr && b != nullptr) score.achieved.push_back({previous, id, world::true_overlap(*a, *b)});
    }
  }
}

}  // namespace

OverlapScore score_overlaps(const intake::Flight& flight, double target, TrueFrames& truth) {
  OverlapScore score;
  if (target > 0) score.target = target;
  measure(flight, truth, score);
  achieve(flight, truth, score);

  std::vector<double> errors, absolute;
  for (const MeasuredOverlap& m : score.measured) {
    errors.push_back(m.measured - m.true_footprint);
    absolute.push_back(std::fabs(errors.back()));
  }
  score.error_bias = host::median(std::move(errors));
  score.error_median = host::median(absolute);
  score.error_p95 = host::percentile(std::move(absolute), 0.95);
  if (score.achieved.empty()) return score;
  const auto n = static_cast<double>(score.achieved.size());
  double sum = 0, squares = 0;
  for (const AchievedOverlap& a : score.achieved) sum += a.true_overlap / n;
  for (const AchievedOverlap& a : score.achieved) squares += (a.true_overlap - sum) * (a.true_overlap - sum);
  score.true_mean = sum;
  if (n > 1) score.true_std = std::sqrt(squares / (n - 1));
  return score;
}

}  // namespace ilp::score
