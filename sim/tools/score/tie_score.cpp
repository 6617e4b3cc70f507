#include "sim/tools/score/tie_score.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Cholesky>

#include "fsw/places/strip_tie.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::score {
namespace {

double share(double part, std::size_t all) {
  return all > 0 ? part / static_cast<double>(all) : std::numeric_limits<double>::quiet_NaN();
}

const StripTrack* track_of(const std::vector<StripScore>& strips, std::int64_t id) {
  const auto found = std::find_if(strips.begin(), strips.end(), [&](const StripScore& s) { return s.id == id; });
  return found == strips.end() ? nullptr : &found->track;
}

std::optional<Similarity> gauge_of(const StripTrack* track) {
  if (track == nullptr || track->metric) return std::nullopt;
  const auto gauge = strip_from_true(*track);
  if (!gauge) return std::nullopt;
  return Similarity{gauge->rotation, gauge->translation, gauge->scale};
}

void add_errors(const SimilarityStep& error, const SimilarityCovariance& covariance, TieScore& score) {
  const Eigen::LLT<SimilarityCovariance> factor(covariance);
  if (factor.info() != Eigen::Success) return;
  score.squared_sum += error.dot(factor.solve(error));
  for (int k = 0; k < 7; ++k) {
    const double normalised = std::fabs(error(k)) / std::sqrt(covariance(k, k));
    ++score.components;
    score.within_one += normalised <= 1 ? 1U : 0U;
    score.within_two += normalised <= 2 ? 1U : 0U;
  }
}

// In units of the newer strip.
void add_place(const Similarity& tied_from_true, std::int64_t keyframe_id, const StripTrack& track, TieScore& score) {
  const auto at = [&](const PoseSample& s) { return s.keyframe_id == keyframe_id; };
  const auto found = std::find_if(track.samples.begin(), track.samples.end(), at);
  if (found == track.samples.end() || !(found->ground_distance > 0)) return;
  const double error = (tied_from_true * found->centre - found->centre).norm();
  score.place_percent.push_back(100 * error / found->ground_distance);
}

}  // namespace

double TieScore::share_within_one() const {
  return share(static_cast<double>(within_one), components);
}
double TieScore::share_within_two() const {
  return share(static_cast<double>(within_two), components);
}
double TieScore::normalised_error_squared() const {
  return share(squared_sum, components);
}

TieScore score_ties(const std::vector<TieRecord>& ties, const std::vector<StripScore>& strips) {
  TieScore score;
  for (const TieRecord& tie : ties) {
    const StripTrack* track = track_of(strips, tie.id);
    const auto this_from_true = gauge_of(track), to_from_true = gauge_of(track_of(strips, tie.to_strip_id));
    if (!this_from_true || !to_from_true) continue;
    const Similarity true_tie = compose(*to_from_true, inverse(*this_from_true));
    const Similarity tied_from_true = compose(inverse(similarity_of(tie)), true_tie);
    ++score.ties;
    add_errors(step_between(Similarity{}, tied_from_true), unpack_covariance(tie.covariance), score);
    add_place(tied_from_true, tie.through_keyframe_id, *track, score);
    score.scale_percent.push_back(100 * std::fabs(tied_from_true.scale - 1));
  }
  return score;
}

std::map<std::string, double> tie_summary(const TieScore& score) {
  if (score.ties == 0) return {};
  return {{"ties", static_cast<double>(score.ties)},
          {"tie_place_percent", host::summarise(score.place_percent).mean},
          {"tie_scale_percent", host::summarise(score.scale_percent).mean},
          {"tie_sigma1_share", score.share_within_one()},
          {"tie_sigma2_share", score.share_within_two()},
          {"tie_nes", score.normalised_error_squared()}};
}

}  // namespace ilp::score
