// The arguments that functions refuse with `invalid_argument`.
#pragma once

#include <cstdint>
#include <limits>

#include "fsw/base/enumeration.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// The first value of `invalid_argument`. Parameters that are checked together have one name. The meaning of a row says
/// which values are valid.
ILP_ENUMERATION(Argument,
                // Images and cameras
                (100, image_size, ""), (101, depth_size, ""), (102, disparity_size, ""), (103, rectified_size, ""),
                (104, mask_size, ""), (105, rows, "inside the image"), (106, camera, "finite numbers"),
                (107, focal_length, "above 1 px, at most 1000 sides of the image, fx and fy within a factor of 10"),
                (108, principal_point, "within one image of its centre"),
                (109, distortion, "invertible over the whole image"), (110, coarsest_side, ""), (111, patch_side, ""),
                (112, view_angle, "at most 75 deg from the optical axis of a fisheye: cut the images to their middle"),
                (113, readout, "at most 0.5 s and the shortest interval between frames"),
                // Overlap and features
                (115, min_overlap, ""), (116, rotation, ""), (117, scale, ""), (118, search_radius, ""),
                (119, homography, ""), (120, corner, ""), (121, corner_count, ""), (122, corner_distance, ""),
                (123, harris_kappa, ""), (124, match, ""), (125, match_parameters, ""), (126, guide, ""),
                (127, slot, ""), (128, features, ""), (129, map_window, ""),
                // Poses and structure
                (130, ransac_threshold, ""), (131, ransac_confidence, ""), (132, ransac_trials, ""),
                (133, min_parallax, ""), (134, max_sigma_direction, ""), (135, views, ""), (136, point, ""),
                (137, observation, ""), (138, scale_hold, ""), (139, height_prior, ""), (140, attitude_prior, ""),
                (141, adjustment_parameters, ""), (142, resection_parameters, ""), (143, sequence_parameters, ""),
                (144, calibration_parameters, ""), (145, window, ""), (146, map_keyframe, ""),
                // Depth, products
                (150, depth_range, ""), (151, disparity_range, ""), (152, stereo_parameters, ""),
                (153, depth_coding, ""), (154, richness_parameters, ""), (155, product_kind, ""), (156, layers, ""),
                (157, coding_parameters, ""), (158, samples, ""), (159, scratch, ""), (160, text, ""),
                // Store, links and devices
                (165, database, "open, and in no transaction"),
                (166, transaction, "one at a time, and open for writing"), (167, blob_field, ""), (168, blob_range, ""),
                (169, capacity, ""), (170, table, ""), (171, file_name, ""),
                (172, open_file, "begun before it is written or ended"), (173, path, ""), (174, job_kind, ""),
                (175, job_input, ""), (176, job_output, ""), (177, watchdog, "not open yet"), (178, store, "in memory"),
                (179, peer, ""),
                // Packets and telecommands
                (185, id_length, ""), (186, sequence_length, ""), (187, pdu_kind, ""), (188, pdu_field, ""),
                (189, channel, ""), (190, security_parameter_index, ""), (191, key_length, ""), (192, interval, ""),
                (193, repetitions, ""), (194, pass_length, ""), (195, component, ""), (196, uplinked_file, ""),
                (197, longitude, "from -360 to 360 deg"), (198, latitude, "from -90 to 90 deg"),
                (199, place_distance, "above 0, at most 100 km"), (200, time_limit, "at most 3000000000 s"))

/// The second value of `invalid_argument` when no single number is wrong. It fits into the four octets that some ground
/// systems have for a value.
inline constexpr std::int64_t no_number = std::numeric_limits<std::int32_t>::min();

/// Returns `invalid_argument` with the refused value in thousandths (type `thousandths` of status_values.hpp).
Status out_of_range(Argument argument, double value);
template <typename Number>
Status out_of_range(Argument argument, Number value) {
  return out_of_range(argument, static_cast<double>(value));
}
/// Returns `invalid_argument` with `no_number`, where no single number is wrong.
Status out_of_range(Argument argument);

}  // namespace ilp
