// The relations that must hold between mission parameters, in addition to the range of each.
#pragma once

#include "fsw/base/enumeration.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// The value of `parameters_contradict`. The numbers 5 and 11 are retired.
ILP_ENUMERATION(
    Relation, (0, none, "no contradiction"), (1, overlaps, "min_overlap below target_overlap"),
    (2, image_bits, "image_bpp_floor at most image_bpp_ceiling"),
    (3, depth_bits, "depth_bpp_floor at most depth_bpp_ceiling"), (4, window, "window_keyframes is not 1 or 2"),
    (6, capture_intervals,
     "capture_min_interval_s at most capture_safe_interval_s, and that at most capture_max_interval_s"),
    (7, passes, "with passes: pass_length_s at most pass_period_s"),
    (8, watermarks, "low_watermark below high_watermark"), (9, weights, "a weight of the richness index is above 0"),
    (10, sequence_octets, "cfdp_sequence_octets is 1, 2, 4 or 8"),
    (12, minor_frame,
     "capture_interval_s, housekeeping_period_s, cfdp_prompt_s and confirmation_timeout_s are 0 or at least 0.1 s"),
    (13, capture_interval, "capture_interval_s is 0 or at least capture_min_interval_s"),
    (14, mission_epoch, "by telecommand: mission_epoch_s is not in the future"),
    (15, agency_epoch, "by telecommand: agency_epoch_s is not in the future, where times count from it"))

[[nodiscard]] constexpr Status contradiction(Relation relation) {
  return {StatusCode::parameters_contradict, static_cast<std::int64_t>(relation)};
}

}  // namespace ilp
