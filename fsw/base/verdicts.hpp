// Verdicts of the kernels of computer vision. Records and reports contain their numbers.
#pragma once

#include "fsw/base/enumeration.hpp"

namespace ilp {

/// Verdict on the overlap of two images.
ILP_ENUMERATION(OverlapVerdict, (0, ok, ""), (1, overlap_unknown, "overlap unknown"), (2, texture_poor, "poor texture"),
                (3, too_dark, "too dark"), (4, blurred, ""))

/// Verdict on the relative pose of two images.
ILP_ENUMERATION(TwoViewVerdict, (0, ok, ""),
                (1, planar, "a homography explains the pair as well; the pose is valid with known intrinsics"),
                (2, too_little_parallax, "a rotation explains the pair, so that no baseline can be estimated"),
                (3, too_few_inliers, "too few inliers"),
                (4, ill_conditioned, "many poses explain the matches: they lie on a line, for example"))

/// Verdict on the pose of a keyframe in its strip. The first keyframe of a strip gets `waiting` until the next one
/// comes. Only the first pair of a strip can get `two_view_failed`.
ILP_ENUMERATION(SequenceVerdict, (0, ok, ""), (1, waiting, "waits for a pair that can begin"),
                (2, too_few_matches, "too few matches"), (3, two_view_failed, "pair gives no pose"),
                (4, resection_failed, "resection failed"), (5, implausible, "implausible step"))

/// Verdict on the self-calibration of the camera in flight.
ILP_ENUMERATION(CalibrationVerdict, (0, searching, "more keyframes will say more"),
                (1, ok, "the images determine the camera"),
                (2, partly, "the images leave some of the intrinsics as uncertain as they were given"),
                (3, unexplained,
                 "no lens explains the images: a rolling shutter, a zoom or focus that changes, a bent image"),
                (4, nothing_seen, "no keyframes with common points: the camera stays as it was given"))

/// Verdict on whether two keyframes show the same ground.
ILP_ENUMERATION(PlaceVerdict, (0, verified, "both show the same ground"),
                (1, too_few_features, "one of the images has too little texture"),
                (2, too_few_matches, "too few features look alike"),
                (3, no_similarity, "no similarity explains enough of the matches"),
                (4, too_few_cells, "the matches that agree are in too few parts of the images"),
                (5, by_chance, "as many matches as unrelated ground of this texture can have"),
                (6, ambiguous, "the ground repeats itself, and another place fits nearly as well"))

/// The model that GRIC (P. Torr, CVPR 1997) prefers for a pair of images.
ILP_ENUMERATION(PairModel, (0, none, "no pair, or too few matches"),
                (1, fundamental, "the fundamental matrix is clearly better: the pair shows relief"),
                (2, homography, "a homography explains the pair as well"))

/// The intrinsics that self-calibration estimates, with OpenCV's distortion.
ILP_ENUMERATION(Intrinsic, (0, focal_length, "focal length"), (1, centre_x, "x of the principal point"),
                (2, centre_y, "y of the principal point"), (3, k1, "radial distortion k1"),
                (4, k2, "radial distortion k2"), (5, p1, "tangential distortion p1"),
                (6, p2, "tangential distortion p2"))
inline constexpr std::size_t intrinsic_count = values_of(Intrinsic{}).size();

/// Why the intrinsics of a given camera are improbable, before any image is used.
ILP_ENUMERATION(
    CameraSuspicion, (0, none, ""),
    (1, field_of_view,
     "its field of view is below 3 or above 130 degrees: is the focal length in px, and for this size?"),
    (2, principal_point,
     "its principal point is outside the middle third of the image: is it that of another size, or of a part?"))

/// Verdict on a strip's agreement with its camera.
ILP_ENUMERATION(CameraCheckVerdict, (0, fits, "the images ask for no other lens"),
                (1, contradicts, "another lens explains the images better"),
                (2, unexplained,
                 "no lens explains the images: a rolling shutter, a zoom or focus that changes, a bent image"),
                (3, nothing_seen, "too few points"))

/// Verdict on the vehicle's measurements from which scale, orientation and position of a strip's frame are estimated.
ILP_ENUMERATION(
    StripFrameVerdict, (0, ok, "the measurements agree"),
    (1, nothing_measured, "fewer than three keyframes have measurements"),
    (2, scales_contradict,
     "heights, positions and velocities give different lengths of the strip unit: the kind that disagrees "
     "with two others is left out, of two kinds both"),
    (3, headings_contradict, "the attitudes' heading is not that of the track: the track's is used"),
    (4, fixes_contradict,
     "the fixes on the map and the vehicle's positions give different places or headings: neither is used"),
    (5, attitudes_contradict,
     "what is up by the attitudes, or by a camera taken to look straight down, is not so by the track of the "
     "positions, which is used; the roll about a straight track stays open"),
    (6, positions_frozen, "the positions stand still while the images move: none is used"))

/// Verdict on the registration of a keyframe against a map.
ILP_ENUMERATION(MapVerdict, (0, fixed, "the keyframe's place on the map is known"),
                (1, no_map, "the map knows too little of the ground that was searched"),
                (2, no_texture, "too few pieces of the keyframe have anything to be known by"),
                (3, no_agreement, "too few pieces of the keyframe agree on one place"),
                (4, at_edge, "the best place is at the edge of what was searched, and the right one may be beyond it"),
                (5, ambiguous, "the ground repeats itself, and another place fits nearly as well"),
                (6, senses_contradict, "image and shape of the map give different places"),
                (7, contradicts_prior, "rotation or height would differ from the prior by more than it errs"))

/// The data of a map that were compared with the keyframe.
ILP_ENUMERATION(MapSense, (0, relit, "the map's image, lit by the sun of the moment"),
                (1, shape, "the map's heights, lit by the sun of the moment"),
                (2, relief, "the map's heights with those of the keyframe: no light is in it"))

}  // namespace ilp
