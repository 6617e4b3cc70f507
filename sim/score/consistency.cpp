#include "sim/score/consistency.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp::score {
namespace {

// Takes the truth's world to the strip's, as the samples [begin, end) see it, with the origin at end - 1.
std::optional<ground::Similarity3> strip_from_true(const StripTrack& track, std::size_t begin, std::size_t end) {
  std::vector<Vec3> centres, true_centres;
  std::vector<Mat3> attitudes, true_attitudes;
  for (std::size_t i = begin; i < end; ++i) {
    const PoseSample& s = track.samples[i];
    centres.push_back(s.centre);
    true_centres.push_back(s.true_centre);
    attitudes.push_back(s.cam_from_world);
    true_attitudes.push_back(s.true_cam_from_world);
  }
  const Mat3 rotation = ground::align_attitudes(true_attitudes, attitudes);
  auto alignment = ground::align_positions(true_centres, centres, rotation);
  if (alignment && !(alignment->scale > 0)) return std::nullopt;
  if (alignment) {
    const PoseSample& origin = track.samples[end - 1];
    alignment->translation = origin.centre - alignment->scale * (rotation * origin.true_centre);
  }
  return alignment;
}

double share(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

void SigmaScore::add(const SigmaScore& other) {
  components += other.components;
  within_one += other.within_one;
  within_two += other.within_two;
  squared_sum += other.squared_sum;
  error.insert(other.error.begin(), other.error.end());
}

double SigmaScore::share_within_one() const {
  return share(within_one, components);
}
double SigmaScore::share_within_two() const {
  return share(within_two, components);
}
double SigmaScore::normalised_error_squared() const {
  return components > 0 ? squared_sum / static_cast<double>(components) : std::numeric_limits<double>::quiet_NaN();
}

SigmaScore score_sigmas(const StripTrack& track) {
  SigmaScore score;
  const std::size_t n = track.samples.size(), window = track.window_keyframes;
  const std::size_t last_window = !track.ended ? n : n > window ? n - window : 0;
  for (std::size_t i = 0; i < n; ++i) {
    const PoseSample& s = track.samples[i];
    const std::size_t before = std::min(i, last_window);
    if (before < 2 || !(s.sigma.minCoeff() > 0)) continue;
    const auto local = strip_from_true(track, before - std::min(before, window), before);
    if (!local) continue;
    const Vec3 error = s.centre - *local * s.true_centre;
    score.error[s.keyframe_id] = error;
    for (int k = 0; k < 3; ++k) {
      const double normalised = error[k] / s.sigma[k];
      ++score.components;
      score.within_one += std::fabs(normalised) <= 1 ? 1U : 0U;
      score.within_two += std::fabs(normalised) <= 2 ? 1U : 0U;
      score.squared_sum += normalised * normalised;
    }
  }
  return score;
}

}  // namespace ilp::score
