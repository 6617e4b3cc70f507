// Measures how much of one image another image shows (paper 3.1; decisions.md, 1 and 2).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"

namespace ilp {

enum class OverlapMethod : std::uint8_t { ncc, sad };

struct OverlapParams {
  OverlapMethod method = OverlapMethod::ncc;
  double min_overlap = 0.5;  ///< the smallest overlap that must be measurable; it sets template size and search range
  double predicted_rotation_rad = 0;  ///< from the pair before, or from attitude sensors
  double predicted_scale = 1;
  double max_rotation_rad = 0.35;  ///< searched on both sides of the prediction; pi is a full turn
  double max_scale = 1.25;         ///< searched from 1 / max_scale to max_scale times the prediction, in all up to 1.5
  double min_ncc = 0.4;            ///< least NCC of the best peak; wrong peaks on real terrain stay below 0.3
  double min_region_ncc = 0.45;    ///< least NCC of every part of the image: a wrong match fits only somewhere
};

struct OverlapResult {
  OverlapVerdict verdict = OverlapVerdict::overlap_unknown;
  double overlap = 0;    ///< area of a seen in b / area of a, in [0, 1], of the two footprints
  Similarity2 b_from_a;  ///< full-resolution pixels
  /// Homography of the ground's plane (row-major, last element 1, full-resolution pixels). It follows the tilt of the
  /// camera.
  double plane_b_from_a[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double ncc = 0;         ///< best peak; the mean of every 8x8 block is removed first, so that shading and large dark
                          ///< patches alone do not correlate
  double ncc_second = 0;  ///< best peak outside the neighbourhood of the first, of those that were registered
  double sigma_px = 0;    ///< one-sigma error of the shift, full-resolution pixels
  /// NCC of the plane in the parts (4 x 4 of image a) that both images show: the smaller of the lower quartile and of
  /// the least NCC of the parts with more than the median of contrast.
  double region_ncc = 0;
  double repetition = 0;  ///< highest peak of a's autocorrelation besides zero: a pattern that matches itself
};

// Defined in overlap_workspace.hpp.
struct OverlapWorkspace;
struct OverlapTemplate;

/// Both images have the same size. Coarse to fine over subsampled images; deterministic, integer sums.
/// `invalid_argument` (a side below limits::min_image_side, min_overlap, max_rotation_rad, scales,
/// predicted_rotation_rad), `image_too_large`, `image_size_changed`.
Status measure_overlap(GrayView image_a, GrayView image_b, const OverlapParams& params, OverlapWorkspace& workspace,
                       OverlapResult& result);

/// The same in two steps, for a keyframe that is compared with many images: its own part is computed once.
/// `image` must stay alive and unchanged as long as the template is used.
Status prepare_overlap(GrayView image, OverlapTemplate& keyframe, OverlapWorkspace& workspace);
Status measure_overlap(const OverlapTemplate& keyframe, GrayView image_b, const OverlapParams& params,
                       OverlapWorkspace& workspace, OverlapResult& result);

/// The measures for the verdicts texture_poor, too_dark and blurred.
struct ImageQuality {
  double mean = 0;       ///< grey levels
  double stddev = 0;     ///< grey levels
  double sharpness = 0;  ///< of the least sharp direction
};
/// Sharpness compares the squared grey differences of neighbours with those of pixels two apart, in each of four
/// directions, and takes the smallest ratio: 0 for a smooth image (differences grow with the distance), 1 for white
/// noise. It detects blur in one direction (motion) as well as in all. measure_overlap computes it at quarter
/// resolution, where the camera's noise no longer counts: sharp terrain has 0.2 to 0.4 there, blurred over 9 px 0.1,
/// over 15 px below 0.06.
[[nodiscard]] ImageQuality assess_image(GrayView image);

/// Area of the footprint intersection under a similarity, as a fraction of the area of image a (width x height each).
[[nodiscard]] double footprint_overlap(std::int32_t width, std::int32_t height, const Similarity2& b_from_a);
/// Share of the area of image a that the homography (row-major) maps into image b.
[[nodiscard]] double footprint_overlap_of_plane(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]);
/// Share of the area of image a that the homographies (row-major) map into image b and from there into image c.
[[nodiscard]] double footprint_shared_by_three(std::int32_t width, std::int32_t height, const double (&b_from_a)[9],
                                               const double (&c_from_b)[9]);
/// How far the homography (row-major) turns the view of the ground's plane: the distances of its corners along the axis
/// change by different factors from image a to image b, and this is the largest factor over the smallest one. It is 1
/// where the camera moves parallel to the plane, climbs or rotates about its axis; infinity where the plane is seen
/// edge-on. No focal length is needed.
[[nodiscard]] double view_turn_of_plane(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]);
/// c_from_a = c_from_b b_from_a, scaled to a last element of 1; `c_from_a` may be one of the factors.
void compose_planes(const double (&c_from_b)[9], const double (&b_from_a)[9], double (&c_from_a)[9]);
/// a_from_b, scaled in the same way; false for a plane seen edge-on, which has no inverse.
[[nodiscard]] bool invert_plane(const double (&b_from_a)[9], double (&a_from_b)[9]);
/// The similarity that maps the centre of image a and its neighbourhood most nearly as the homography (row-major) does.
[[nodiscard]] Similarity2 similarity_at_centre(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]);

}  // namespace ilp
