// The homography as a problem for ransac(), and its robust estimate.
#pragma once

#include "fsw/vision/twoview/robust/ransac.hpp"
#include "fsw/vision/twoview/solvers/normalised_pairs.hpp"

namespace ilp {

struct HomographyProblem {
  using Model = Mat3;
  static constexpr std::size_t sample_size = 4;
  static constexpr std::size_t max_models = 1;

  const NormalisedPairs& pairs;
  double threshold_px;
  PairIndices& scratch;

  std::size_t solve(const std::uint16_t* sample, Model* models) const;
  bool score(const Model& model, const CostBound& bound, RansacScore& score) const;
  bool improve(Model& model);
};

/// Selects the matches with a transfer error below `threshold_px`. Returns the sum of their squared errors, px^2.
double select_homography_inliers(const NormalisedPairs& pairs, const Mat3& homography, double threshold_px,
                                 PairIndices& selected);

/// find_homography in slices: call begin_homography once, then homography_slice with the same arguments while it
/// returns true. end_homography then gives the result.
void begin_homography(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch,
                      RansacRun<Mat3>& run);
bool homography_slice(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch,
                      RansacRun<Mat3>& run);
bool end_homography(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch,
                    const RansacRun<Mat3>& run, Mat3& homography);
/// Finds the best homography of `pairs` and refines it. Returns false if there is none.
bool find_homography(const NormalisedPairs& pairs, const RansacParams& params, PairIndices& scratch, Mat3& homography);

/// GRIC of a homography between normalised coordinates over all of `pairs`.
[[nodiscard]] double homography_gric(const NormalisedPairs& pairs, const Mat3& homography, double sigma_px);

/// Standard deviation of the inliers' errors, px: half the threshold, so that 95 % of the inliers are within it.
[[nodiscard]] inline double sigma_of(const RansacParams& params) {
  return 0.5 * params.threshold_px;
}

}  // namespace ilp
