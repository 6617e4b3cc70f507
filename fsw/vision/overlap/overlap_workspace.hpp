// Memory of measure_overlap; a component owns one workspace, and one template per keyframe that it keeps.
#pragma once

#include <array>

#include "fsw/vision/image/pyramid.hpp"
#include "fsw/vision/overlap/coarse_search.hpp"
#include "fsw/vision/overlap/overlap.hpp"
#include "fsw/vision/overlap/registration.hpp"
#include "fsw/vision/overlap/repetition.hpp"

namespace ilp {

using CoarseImage = std::array<std::int16_t, static_cast<std::size_t>(coarse_max_side) * coarse_max_side>;

struct OverlapTemplate {
  // Levels from registration_max_side down to at most twice coarse_max_side.
  static constexpr int max_levels = 3;
  static_assert((registration_max_side >> (max_levels - 1)) <= 2 * coarse_max_side);

  Pyramid pyramid;
  ImageQuality quality;
  double repetition = 0;
  CoarseImage coarse{};
  int finest = 0, first = 0;                            ///< pyramid levels on which the registration ends, and begins
  std::array<RegistrationTemplate, max_levels> levels;  ///< finest first
};

/// A candidate of the coarse search while it is registered.
struct OverlapHypothesis {
  CentredSimilarity b_from_a;
  RegistrationFit fit;
  int steps = 0;        ///< done on this level
  bool goes_on = true;  ///< another step may improve it
};

struct OverlapWorkspace {
  OverlapTemplate a;
  Pyramid b;
  CoarseImage coarse_b{};
  RegistrationImage registered;  ///< the level of b that is being registered
  CoarseWorkspace coarse;
  CoarseCandidates candidates;
  FixedVector<OverlapHypothesis, coarse_max_candidates> hypotheses;
  RepetitionWorkspace repetition;
};

/// The level of a pyramid on which a wide search runs (prepare_wide_search() in wide_search.hpp).
[[nodiscard]] int wide_search_level(const Pyramid& pyramid);

/// Measures the overlap as measure_overlap(), from the peaks of a wide search instead of its own search. `candidates`
/// are in px of the level wide_search_level(). Returns the errors of measure_overlap().
Status measure_overlap_of(const OverlapTemplate& keyframe, GrayView image_b, const CoarseCandidates& candidates,
                          const OverlapParams& params, OverlapWorkspace& workspace, OverlapResult& result);

}  // namespace ilp
