#include "sim/tools/score/tie_score.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

#include "fsw/vision/geometry/similarity.hpp"
#include "sim/ground/model/ties.hpp"
#include "sim/host/statistics.hpp"

namespace ilp::score {
namespace {

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

void add_errors(const SimilarityStep& error, const SimilarityCovariance& covariance, SigmaScore& score) {
  const Eigen::LLT<SimilarityCovariance> factor(covariance);
  if (factor.info() != Eigen::Success) return;
  score.squared_sum += error.dot(factor.solve(error));
  for (int k = 0; k < 7; ++k) score.count(error(k) / std::sqrt(covariance(k, k)));
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

TieScore score_ties(const intake::Flight& flight, const std::vector<StripScore>& strips) {
  TieScore score;
  for (const TieRecord& tie : flight.ties) {
    const auto stated = model::similarity_by_tie(flight, tie);
    const StripTrack* track = track_of(strips, tie.id);
    const auto this_from_true = gauge_of(track), to_from_true = gauge_of(track_of(strips, tie.to_strip_id));
    if (!stated || !this_from_true || !to_from_true) continue;
    const Similarity true_tie = compose(*to_from_true, inverse(*this_from_true));
    const Similarity tied_from_true = compose(inverse(*stated), true_tie);
    ++score.ties;
    add_errors(step_between(Similarity{}, tied_from_true), unpack_covariance(tie.covariance), score.sigmas);
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
          {"tie_sigma1_share", score.sigmas.share_within_one()},
          {"tie_sigma2_share", score.sigmas.share_within_two()},
          {"tie_nes", score.sigmas.normalised_error_squared()}};
}

}  // namespace ilp::score
