// Measures the overlap of two images: the share of image a that image b shows (paper 3.1; decisions.md, 1 and 2).
#pragma once

#include "fsw/base/geometry.hpp"
#include "fsw/base/image_view.hpp"
#include "fsw/base/status.hpp"
#include "fsw/base/verdicts.hpp"

namespace ilp {

enum class OverlapMethod : std::uint8_t { ncc, sad };

struct OverlapParams {
  OverlapMethod method = OverlapMethod::ncc;
  double min_overlap = 0.5;           ///< smallest overlap that must be found; it sets the range of shifts
  double predicted_rotation_rad = 0;  ///< from the previous pair, or from attitude sensors
  double predicted_scale = 1;
  double max_rotation_rad = 0.35;  ///< searched to both sides of the prediction; pi is a full turn
  double max_scale = 1.25;       ///< searched from 1 / max_scale to max_scale times the prediction; 1.5 is the largest
  double min_ncc = 0.4;          ///< least NCC of the best peak; wrong peaks on real terrain stay below 0.3
  double min_region_ncc = 0.45;  ///< least region_ncc of the result: a wrong match fits only in some parts
};

struct OverlapResult {
  OverlapVerdict verdict = OverlapVerdict::overlap_unknown;
  double overlap = 0;    ///< area of a that b shows divided by the area of a, 0 to 1
  Similarity2 b_from_a;  ///< full-resolution pixels
  /// Homography of the ground's plane (row-major, last element 1, full-resolution pixels). Unlike `b_from_a` it models
  /// a tilt of the camera.
  double plane_b_from_a[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  /// NCC of the best peak. The mean of every block is removed first, so that shading and large dark patches alone do
  /// not correlate.
  double ncc = 0;
  double ncc_second = 0;  ///< NCC of the best other peak that was registered; 0 if there is none
  double sigma_px = 0;    ///< standard deviation of the shift, full-resolution pixels
  /// Weakest NCC among the parts of image a (4 x 4) that b shows at least half of. It is the smaller of two values: the
  /// lower quartile over all these parts, and the minimum over the half with the most contrast. 0 with fewer than four
  /// parts.
  double region_ncc = 0;
  double repetition = 0;  ///< highest peak of the autocorrelation of a, other than at shift 0 (repetition.hpp)
};

// Defined in overlap_workspace.hpp.
struct OverlapWorkspace;
struct OverlapTemplate;

/// Searches all rotations, scales and shifts in the range of `params` on small images, and registers the best peaks
/// from coarse to fine. Deterministic. Images that do not overlap are no error: see OverlapResult::verdict. Returns
/// `invalid_argument` (a side below limits::min_image_side, or a parameter out of range), `image_too_large`, or
/// `image_size_changed` if the sizes differ.
Status measure_overlap(GrayView image_a, GrayView image_b, const OverlapParams& params, OverlapWorkspace& workspace,
                       OverlapResult& result);

/// measure_overlap in two steps, for a keyframe that is compared with many images: prepare_overlap computes its
/// template once. `image` must stay alive and unchanged as long as the template is used. Returns `not_ready` if the
/// template was not prepared, otherwise the same errors.
Status prepare_overlap(GrayView image, OverlapTemplate& keyframe, OverlapWorkspace& workspace);
Status measure_overlap(const OverlapTemplate& keyframe, GrayView image_b, const OverlapParams& params,
                       OverlapWorkspace& workspace, OverlapResult& result);

/// Measures of an image for the verdicts `texture_poor`, `too_dark` and `blurred`.
struct ImageQuality {
  double mean = 0;       ///< grey levels
  double stddev = 0;     ///< grey levels
  double sharpness = 0;  ///< of the least sharp direction, see assess_image()
};
/// Measures mean, standard deviation and sharpness. Sharpness is the smallest ratio, over four directions, of the
/// squared grey differences of neighbours to those of pixels two apart, scaled so that a smooth image has 0
/// (differences grow with the distance) and white noise 1. It detects blur in one direction (motion) as well as in all.
/// measure_overlap computes it at quarter resolution, where the camera's noise no longer counts: sharp terrain has 0.2
/// to 0.4 there, blurred over 9 px 0.1, over 15 px below 0.06.
[[nodiscard]] ImageQuality assess_image(GrayView image);

/// Share of the area of image a that the similarity maps into image b. Both images have `width` x `height` pixels.
[[nodiscard]] double footprint_overlap(std::int32_t width, std::int32_t height, const Similarity2& b_from_a);
/// Share of the area of image a that the homography (row-major) maps into image b.
[[nodiscard]] double footprint_overlap_of_plane(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]);
/// Share of the area of image a that the homographies (row-major) map into image b and from there into image c.
[[nodiscard]] double footprint_shared_by_three(std::int32_t width, std::int32_t height, const double (&b_from_a)[9],
                                               const double (&c_from_b)[9]);
/// Measures how much the direction of view onto the ground's plane changes from image a to image b. The depths of the
/// image's corners on the plane change by different factors; the result is the largest factor divided by the smallest.
/// It is 1 if the camera moves parallel to the plane, climbs or rotates about its axis, and infinite if the plane is
/// seen edge-on. No focal length is needed.
[[nodiscard]] double view_turn_of_plane(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]);
/// c_from_a = c_from_b b_from_a, scaled to a last element of 1; `c_from_a` may be one of the factors.
void compose_planes(const double (&c_from_b)[9], const double (&b_from_a)[9], double (&c_from_a)[9]);
/// a_from_b, scaled in the same way. Returns false if the plane is seen edge-on: there is no inverse.
[[nodiscard]] bool invert_plane(const double (&b_from_a)[9], double (&a_from_b)[9]);
/// The similarity nearest to the homography (row-major) around the centre of image a.
[[nodiscard]] Similarity2 similarity_at_centre(std::int32_t width, std::int32_t height, const double (&b_from_a)[9]);

}  // namespace ilp
