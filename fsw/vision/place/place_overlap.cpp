#include "fsw/vision/place/place_overlap.hpp"

#include <algorithm>
#include <cmath>

#include "fsw/vision/place/place_scratch.hpp"

namespace ilp {
namespace {

/// Images that follow each other are likely to share ground, and each has one neighbour, where a memory of places
/// compares every keyframe with many.
constexpr float least_evidence_of_neighbours = 3;

Status compare(GrayView image_a, GrayView image_b, std::size_t features, PlaceScratch& scratch) {
  PlaceFeatures& a = scratch.found[0];
  PlaceFeatures& b = scratch.found[1];
  ILP_TRY(find_place_features(image_a, features, scratch.harris, scratch.features, a));
  ILP_TRY(find_place_features(image_b, features, scratch.harris, scratch.features, b));
  return verify_place({a.data(), a.size()}, {b.data(), b.size()}, least_evidence_of_neighbours, scratch.match,
                      scratch.verified);
}

}  // namespace

Status measure_overlap_by_places(GrayView image_a, GrayView image_b, std::size_t most_features, PlaceScratch& scratch,
                                 OverlapResult& result) {
  result = {};
  result.verdict = OverlapVerdict::overlap_unknown;
  if (image_a.width != image_b.width || image_a.height != image_b.height) return StatusCode::image_size_changed;
  PlaceMatch& match = scratch.verified;
  ILP_TRY(compare(image_a, image_b, limits::place_features, scratch));
  if (match.verdict != PlaceVerdict::verified && most_features > limits::place_features)
    ILP_TRY(compare(image_a, image_b, most_features, scratch));
  const double last = match.plane_newer_from_older[8];
  if (match.verdict != PlaceVerdict::verified || std::fabs(last) < 1e-12) return {};
  for (int i = 0; i < 9; ++i) result.plane_b_from_a[i] = match.plane_newer_from_older[i] / last;
  result.sigma_px = match.residual_px;
  result.b_from_a = similarity_at_centre(image_a.width, image_a.height, result.plane_b_from_a);
  result.overlap = footprint_overlap_of_plane(image_a.width, image_a.height, result.plane_b_from_a);
  result.verdict = OverlapVerdict::ok;
  return {};
}

}  // namespace ilp
