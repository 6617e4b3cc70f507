// Run-time parameters of a mission: what an .ini file or a telecommand may change. One table gives names, units, ranges
// and defaults; the file format, the users' guide and the parameter service follow from it.
#pragma once

#include <cstddef>
#include <cstdint>

#include "fsw/base/status.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

struct MissionParameters {
  // [acquisition]
  double capture_mode = 0;
  double capture_interval_s = 0;
  double capture_min_interval_s = 0.5;
  double capture_safe_interval_s = 2;
  double capture_max_interval_s = 60;
  double capture_max_sigma = 0.03;
  double capture_timeout_s = 3;
  // [overlap]
  double target_overlap = 0.82;
  double min_overlap = 0.55;
  double selection_slack = 0.03;
  double max_rotation_rad = 0.35;
  double max_scale = 1.25;
  double overlap_sad = 0;
  double feature_overlap = 1;
  // [motion]
  double corners = 1000;
  double search_radius_px = 40;
  double window_keyframes = 0;
  double ransac_threshold_px = 1.0;
  double resection_threshold_px = 1.0;
  // [calibration]
  double camera_known = 1;
  double calibration_patience_keyframes = 60;
  // [stereo]
  double min_correlation = 0.3;
  double depth_step_px = 0.0625;
  // [richness]: a cue counts as cue / (cue + half), times its weight
  double gradient_fine_half = 1.7, gradient_fine_weight = 2.7;
  double gradient_coarse_half = 2.1, gradient_coarse_weight = 2.2;
  double entropy_half = 2.4, entropy_weight = 0.3;
  double contrast_half = 3.7, contrast_weight = 1.6;
  double relief_half = 0.013, relief_weight = 0.38;
  double slope_steep_half = 0.1, slope_steep_weight = 0.3;
  double slope_excess_half = 0.066, slope_excess_weight = 0.3;
  double roughness_fine_half = 0.03, roughness_fine_weight = 0.38;
  double roughness_coarse_half = 0.02, roughness_coarse_weight = 1.2;
  double curvature_half = 0.026, curvature_weight = 0.87;
  double novelty_half = 1, novelty_weight = 0.3;
  double novelty_memory_images = 500;
  double sensor_noise_grey = 1.5;
  // [products]
  double image_bpp_floor = 0.5;
  double image_bpp_ceiling = 2.0;
  double depth_bpp_floor = 1.0;
  double depth_bpp_ceiling = 4.0;
  double depth_error_px = 0.25;
  double quality_layers = 4;
  double thumbnail_below = 0.05;
  double lossless_above = 1;
  double region_coding = 1;
  double region_resolutions = 1;
  // [storage]
  double storage_budget_mib = 256;
  double frame_share = 0.6;
  double depth_share = 0.4;
  double product_share = 1;
  double high_watermark = 0.95;
  double low_watermark = 0.85;
  double history_frames = 20000;
  double history_keyframes = 2000;
  // [downlink]
  double link_bytes_per_s = 200000;
  double pass_period_s = 0;
  double pass_length_s = 600;
  double pass_start_s = 0;
  double pass_count = 0;
  double overdue_passes = 4;
  double downlink_order = 0;
  double confirmation_timeout_s = 86400;
  // [link]
  double cfdp_entity = 1;
  double cfdp_ground_entity = 2;
  double cfdp_sequence_octets = 2;
  double cfdp_checksum = 3;
  double cfdp_pdu_crc = 0;
  double cfdp_segment_bytes = 1000;
  double cfdp_metadata_copies = 2;
  double cfdp_open_transfers = 8;
  double cfdp_timer_s = 10;
  double cfdp_timer_limit = 4;
  double cfdp_rest_s = 60;
  double cfdp_prompt_s = 0;
  double cfdp_inactivity_s = 300;
  double cfdp_queue_kib = 4096;
  double apid = 239;
  double telecommands_per_s = 200;
  double authentication = 0;
  double tailoring = 0;
  double cuc_time = 0;
  double mission_epoch_s = 2145916800;
  double agency_epoch_s = 1325376000;
  // [flight]
  double seed = 1;
  double safe_mode = 0;
  // [contact]: what the ground has commanded, above the pass schedule
  double opened_s = 0, opened_until_s = 0;
  double closed_s = 0, closed_until_s = 0;
  double trial_s = 1800;
  // [executive]: on board, where time passes while components work
  double housekeeping_period_s = 60;
  double degraded_modes = 1;
  double load_window_s = 10;
  double overload_overruns = 0.3;
  double overload_frames = 12;
  double overload_keyframes = 4;
  double recovery_windows = 6;
  double scrub_bytes_per_s = 50000;
  double scrub_period_s = 3600;
  double image_check_bytes_per_s = 1e6;
};

struct ParameterInfo {
  std::uint16_t number;  ///< on the link and in stored settings, for ever; from 1
  const char* section;
  const char* key;
  std::size_t offset;  ///< of a double in MissionParameters
  const char* unit;
  double minimum, maximum;
  const char* description;
};

/// How a parameter goes over the link, and when a value takes effect that is set there.
struct ParameterLink {
  FieldType type = FieldType::f64;
  bool at_restart = false;  ///< with the next start of the flight software; else at once
};

[[nodiscard]] std::size_t parameter_count();
[[nodiscard]] const ParameterInfo& parameter_info(std::size_t index);
[[nodiscard]] ParameterLink parameter_link(std::size_t index);
/// Of a name; parameter_count() when there is none.
[[nodiscard]] std::size_t find_parameter(const char* section, const char* key);
/// Of a number from the link or the store; parameter_count() when there is none.
[[nodiscard]] std::size_t find_parameter(std::uint64_t number);
[[nodiscard]] double parameter_value(const MissionParameters& mission, std::size_t index);

/// `not_found` for an unknown name, `invalid_argument` (a = index) for a value out of range or not a number.
Status set_parameter(MissionParameters& mission, const char* section, const char* key, double value);
Status set_parameter(MissionParameters& mission, std::size_t index, double value);
/// Relations between parameters that a single range cannot state: `invalid_argument` with the relation's number
/// (docs/commanding.md).
Status validate(const MissionParameters& mission);

/// decisions.md, 5: ceil(1 / (1 - target overlap)), unless the mission names a length.
[[nodiscard]] std::uint32_t window_length(const MissionParameters& mission);

}  // namespace ilp
