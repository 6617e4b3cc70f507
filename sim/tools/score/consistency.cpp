#include "sim/tools/score/consistency.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ilp::score {
namespace {

// Takes the truth's world to the strip's, by the first camera and the first baseline.
std::optional<host::Similarity3> strip_from_true(const StripTrack& track) {
  const PoseSample& first = track.samples[0];
  const PoseSample& second = track.samples[1];
  const double length = (second.true_centre - first.true_centre).norm();
  if (!(length > 0)) return std::nullopt;
  host::Similarity3 alignment;
  alignment.scale = (second.centre - first.centre).norm() / length;
  alignment.rotation = first.cam_from_world.transpose() * first.true_cam_from_world;
  alignment.translation = first.centre - alignment.scale * (alignment.rotation * first.true_centre);
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
  if (!track.from_the_start || track.samples.size() < 3) return score;
  const auto gauge = strip_from_true(track);
  if (!gauge) return score;
  for (std::size_t i = 2; i < track.samples.size(); ++i) {
    const PoseSample& s = track.samples[i];
    if (!(s.sigma.minCoeff() > 0)) continue;
    const Vec3 error = s.centre - *gauge * s.true_centre;
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
