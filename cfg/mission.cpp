#include "cfg/mission.hpp"

#include <cmath>
#include <cstring>
#include <iterator>

#include "cfg/limits.hpp"
#include "cfg/schedule.hpp"

namespace ilp {
namespace {

// A number names the parameter on the link and in stored settings: it is never changed and never used again. New rows
// take numbers that tests/unit/cfg/numbers.txt does not hold, and are added there.
#define P(number, section, key, unit, minimum, maximum, description)                             \
  ParameterInfo {                                                                                \
    number, section, #key, offsetof(MissionParameters, key), unit, minimum, maximum, description \
  }

#define CUE(number, name, unit, meaning)                                                                      \
  P(number, "richness", name##_half, unit, 1e-6, 1e6, meaning ": the strength at which the cue counts half"), \
      P((number) + 1, "richness", name##_weight, "", 0, 100, "of " #name " in the index")

constexpr ParameterInfo infos[] = {
    P(1, "acquisition", capture_mode, "", 0, 2,
      "0 regular interval, 1 when the forecast overlap reaches its target, 2 only when telecommanded"),
    P(2, "acquisition", capture_interval_s, "s", 0, 3600, "between two frames in mode 0; 0 takes every frame"),
    P(3, "acquisition", capture_min_interval_s, "s", 0.01, 3600, "the camera's shortest interval between exposures"),
    P(4, "acquisition", capture_safe_interval_s, "s", 0.1, 3600, "in mode 1 while nothing is known of the motion"),
    P(5, "acquisition", capture_max_interval_s, "s", 0.1, 86400, "in mode 1 at the latest after this, in hover too"),
    P(6, "acquisition", capture_max_sigma, "", 0.001, 1,
      "in mode 1 a frame is taken on the way when the forecast overlap is less certain than this"),
    P(7, "acquisition", capture_timeout_s, "s", 0.1, 3600, "a capture without a frame after this has none"),
    P(8, "overlap", target_overlap, "", 0.5, 0.98, "a frame at or below it becomes the next keyframe"),
    P(9, "overlap", min_overlap, "", 0.2, 0.95, "below it the strip ends: structure and motion cannot bridge it"),
    P(10, "overlap", selection_slack, "", 0, 0.2,
      "in mode 1 of acquisition a frame so little above the target becomes the next keyframe too"),
    P(11, "overlap", max_rotation_rad, "rad", 0, 3.1416, "rotation searched on both sides of the last one"),
    P(12, "overlap", max_scale, "", 1, 1.5, "scale searched from its inverse to it"),
    P(13, "overlap", overlap_sad, "", 0, 1, "1 compares by absolute differences instead of correlation"),
    P(14, "overlap", feature_overlap, "", 0, 1, "1 asks corner matches where correlation cannot tell"),
    P(15, "motion", corners, "", 100, static_cast<double>(limits::max_corners), "corners per keyframe"),
    P(16, "motion", search_radius_px, "px", 8, 200, "how far relief and tilt may move a corner from its prediction"),
    P(17, "motion", window_keyframes, "", 0, static_cast<double>(limits::max_window_keyframes),
      "bundle adjustment window; 0 derives it from the target overlap"),
    P(18, "motion", ransac_threshold_px, "px", 0.1, 10, "inlier bound of the relative pose"),
    P(19, "motion", resection_threshold_px, "px", 0.1, 10, "inlier bound of the resection"),
    P(20, "calibration", camera_known, "", 0, 1,
      "0: the camera's intrinsics are nominal only; they are found from the keyframes, and nothing metric is computed "
      "before"),
    P(21, "calibration", calibration_patience_keyframes, "", 6, 1000,
      "so many keyframes wait for the intrinsics, or as many as half the storage budget holds; older ones get no pose"),
    P(22, "stereo", min_correlation, "", 0, 1, "weaker matches are invalid"),
    P(23, "stereo", depth_step_px, "px", 0.01, 1, "depth is sent in steps of this disparity"),
    CUE(24, gradient_fine, "", "of the image at 2 px, striking over ordinary places"),
    CUE(26, gradient_coarse, "", "of the image at 4 px, striking over ordinary places"),
    CUE(28, entropy, "bit", "of the image"),
    CUE(30, contrast, "", "of spots against their surroundings: stones"),
    CUE(32, relief, "", "height range / distance"),
    CUE(34, slope_steep, "", "tangent of the steepest slopes"),
    CUE(36, slope_excess, "", "of the steepest slopes over the ordinary ones: scarps, not hillsides"),
    CUE(38, roughness_fine, "", "left over by planes 20 px wide"),
    CUE(40, roughness_coarse, "", "left over by planes 52 px wide: hummocks, channels"),
    CUE(42, curvature, "", "of places 36 px wide: bowls, knobs, ledges"),
    CUE(44, novelty, "sigma", "against what the flight has seen"),
    P(46, "richness", novelty_memory_images, "", 3, 1e6,
      "what is so many images ago fades from what the flight has seen"),
    P(47, "richness", sensor_noise_grey, "grey", 0, 50, "standard deviation of the sensor's noise: no gradient"),
    P(48, "products", image_bpp_floor, "bit/px", 0.02, 8, "for the dullest image, per newly seen pixel"),
    P(49, "products", image_bpp_ceiling, "bit/px", 0.02, 16, "for the richest image, per newly seen pixel"),
    P(50, "products", depth_bpp_floor, "bit/px", 0.02, 16, "for the dullest depth map, per newly seen pixel"),
    P(51, "products", depth_bpp_ceiling, "bit/px", 0.02, 16, "for the richest depth map, per newly seen pixel"),
    P(52, "products", depth_error_px, "px", 0, 8,
      "largest error of disparity asked of a depth map: layers beyond the first that keeps it are left off; 0: none "
      "are"),
    P(53, "products", quality_layers, "", 1, static_cast<double>(limits::max_quality_layers), "layers of a codestream"),
    P(54, "products", thumbnail_below, "", 0, 1, "an index below it is sent as a thumbnail"),
    P(55, "products", lossless_above, "", 0, 1,
      "above this index new ground is sent exactly, where the link is no limit"),
    P(56, "products", region_coding, "", 0, 1,
      "0 codes images and depth maps whole, 1 the newly seen part before the rest"),
    P(57, "products", region_resolutions, "", 0, 4, "coarsest resolutions that count as region everywhere"),
    P(58, "storage", storage_budget_mib, "MiB", 1, 1048576, "what frames, maps, points and products may take"),
    P(59, "storage", frame_share, "", 0.01, 1, "raw frames may take this share of the budget"),
    P(60, "storage", depth_share, "", 0.01, 1, "depth maps may take this share of the budget"),
    P(61, "storage", product_share, "", 0.01, 1, "products may take this share of the budget"),
    P(62, "storage", high_watermark, "", 0.1, 1, "of the budget or a share: beyond it least worth is given up"),
    P(63, "storage", low_watermark, "", 0.05, 1, "of the budget or a share: down to it least worth is given up"),
    P(64, "storage", history_frames, "", 100, 1e7, "so many of the newest frames keep their records on board"),
    P(65, "storage", history_keyframes, "", 100, 1e6,
      "so many of the newest keyframes keep their records on board; those that the ground has not confirmed ten times "
      "as "
      "long"),
    P(66, "downlink", link_bytes_per_s, "byte/s", 0, 1e9, "mean rate of the link while there is contact"),
    P(67, "downlink", pass_period_s, "s", 0, 1e7,
      "from the start of one pass to that of the next; 0: always in contact"),
    P(68, "downlink", pass_length_s, "s", 1, 1e7, "how long a pass has contact; at most the period"),
    P(69, "downlink", pass_start_s, "s", 0, 1e9, "mission time at which the first pass starts"),
    P(70, "downlink", pass_count, "", 0, 1e6, "passes until the link ends for good; 0: it never does"),
    P(71, "downlink", overdue_passes, "", 1, static_cast<double>(limits::max_overdue_passes),
      "a product of which nothing has gone for so many passes goes before others (without passes: of 120 s each)"),
    P(72, "downlink", confirmation_timeout_s, "s", 0, 1e8,
      "a product's file that the ground has not confirmed after so long counts as lost and goes again; 0: never"),
    P(73, "downlink", downlink_order, "", 0, 1, "0 what is worth most for its bytes goes first, 1 in order of origin"),
    P(74, "link", cfdp_entity, "", 0, 65535, "CFDP entity ID of the package"),
    P(75, "link", cfdp_ground_entity, "", 0, 65535, "CFDP entity ID that products are sent to"),
    P(76, "link", cfdp_sequence_octets, "", 1, 8, "length of transaction sequence numbers: 1, 2, 4 or 8"),
    P(77, "link", cfdp_checksum, "", 0, 15, "checksum of files: 0 modular, 2 CRC-32C, 3 CRC-32, 15 none"),
    P(78, "link", cfdp_pdu_crc, "", 0, 1, "1: every PDU carries a CRC of its own"),
    P(79, "link", cfdp_segment_bytes, "byte", 16, 1900, "of a file in one PDU"),
    P(80, "link", cfdp_metadata_copies, "", 1, 8, "so often the metadata go at the beginning of a transfer"),
    P(81, "link", cfdp_open_transfers, "", 1, static_cast<double>(limits::max_transfers),
      "transfers to the ground at once"),
    P(82, "link", cfdp_timer_s, "s", 0.1, 86400, "of contact, until an EOF, a NAK or a Finished goes again"),
    P(83, "link", cfdp_timer_limit, "", 1, 1000, "so often, then a transfer down rests and one up is given up"),
    P(84, "link", cfdp_rest_s, "s", 0.1, 86400, "of contact, until a transfer that nobody answered goes on"),
    P(85, "link", cfdp_prompt_s, "s", 0, 86400, "of contact without news of a transfer, then a prompt goes; 0: never"),
    P(86, "link", cfdp_inactivity_s, "s", 1, 1e6, "of contact without news, then a transfer up is given up"),
    P(87, "link", cfdp_queue_kib, "KiB", 1, 1048576, "files on their way to the ground may take about so much"),
    P(88, "link", apid, "", 0, 2044, "application process identifier of this package in space packets"),
    P(89, "link", telecommands_per_s, "1/s", 1, 10000, "telecommands beyond this rate wait, then are lost"),
    P(90, "link", authentication, "", 0, 2,
      "0 none, 1 telecommands must be authenticated, 2 CFDP PDUs too; off where there are no keys (docs/links.md)"),
    P(91, "link", tailoring, "", 0, 2, "widths of fields: 0 default, 1 fsfw, 2 yamcs (docs/commanding.md)"),
    P(92, "link", cuc_time, "", 0, 1, "1: times are CUC 4+3 of the agency's epoch in every tailoring"),
    P(93, "link", mission_epoch_s, "s", 0, 6e9,
      "UTC when mission time was 0, in seconds since 1958-01-01 without leap seconds"),
    P(94, "link", agency_epoch_s, "s", 0, 4e9, "UTC of the agency's epoch, likewise; whole seconds"),
    P(95, "flight", seed, "", 0, 4294967295.0, "seed of every random choice"),
    P(96, "flight", safe_mode, "", 0, 1,
      "1: images at the safe interval only, no depth maps, no products; telecommanded captures as ever"),
    P(97, "contact", opened_s, "s", 0, 1e9, "beginning of a pass that was commanded"),
    P(98, "contact", opened_until_s, "s", 0, 1e9, "its end"),
    P(99, "contact", closed_s, "s", 0, 1e9, "beginning of the time without contact that was commanded"),
    P(100, "contact", closed_until_s, "s", 0, 1e9, "its end"),
    P(118, "contact", trial_s, "s", 60, 86400,
      "of contact without any telecommand, then parameters that decide about contact or act with a start are given up "
      "for the last good ones (docs/getting-back-in.md)"),
    P(101, "executive", housekeeping_period_s, "s", 0, 86400,
      "in real time the records component and timing are written so often; 0: at the end of a flight only"),
    P(102, "executive", degraded_modes, "", 0, 1,
      "1: in real time keyframes get fewer features, then coarser stereo, while the package does not keep up"),
    P(103, "executive", load_window_s, "s", 1, 3600, "so long minor frames are counted before the load is judged"),
    P(104, "executive", overload_overruns, "", 0.01, 1,
      "share of a window lost to overruns from which work is reduced"),
    P(105, "executive", overload_frames, "", 1, 100000,
      "so many frames wait for the overlap checker in a window without rest: work is reduced"),
    P(106, "executive", overload_keyframes, "", 1, 1000,
      "so many keyframes beyond the adjustment window wait for pose, depth or richness, likewise"),
    P(107, "executive", recovery_windows, "", 1, 1000,
      "so many windows in a row below half of those limits until work is restored by one level"),
    P(115, "executive", scrub_bytes_per_s, "B/s", 0, 1e9,
      "the store is read through at this pace and what is damaged is reported; 0: not"),
    P(116, "executive", scrub_period_s, "s", 0, 1e7, "the store is read through at most once in so much time"),
    P(117, "executive", image_check_bytes_per_s, "B/s", 0, 1e9,
      "code and constants in memory are compared with what was loaded at this pace; 0: not"),
};
#undef CUE
#undef P

constexpr bool numbers_are_unique() {
  for (std::size_t i = 0; i < std::size(infos); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (infos[i].number == infos[k].number) return false;
    }
  }
  return true;
}
static_assert(numbers_are_unique(), "a number of a parameter is there twice");

/// Whole numbers, and what a running flight does not follow. The others go as f64 and take effect at once.
struct LinkRow {
  const char* key;
  ParameterLink link;
};
constexpr LinkRow link_rows[] = {
    {"capture_mode", {FieldType::u8, false}},
    {"overlap_sad", {FieldType::u8, false}},
    {"feature_overlap", {FieldType::u8, false}},
    {"corners", {FieldType::u16, false}},
    {"window_keyframes", {FieldType::u8, false}},
    {"camera_known", {FieldType::u8, true}},
    {"calibration_patience_keyframes", {FieldType::u16, false}},
    {"novelty_memory_images", {FieldType::u32, false}},
    {"quality_layers", {FieldType::u8, false}},
    {"region_coding", {FieldType::u8, false}},
    {"region_resolutions", {FieldType::u8, false}},
    {"storage_budget_mib", {FieldType::u32, false}},
    {"history_frames", {FieldType::u32, false}},
    {"history_keyframes", {FieldType::u32, false}},
    {"link_bytes_per_s", {FieldType::u32, false}},
    {"pass_count", {FieldType::u32, false}},
    {"overdue_passes", {FieldType::u8, false}},
    {"downlink_order", {FieldType::u8, false}},
    {"cfdp_entity", {FieldType::u16, true}},
    {"cfdp_ground_entity", {FieldType::u16, true}},
    {"cfdp_sequence_octets", {FieldType::u8, true}},
    {"cfdp_checksum", {FieldType::u8, false}},
    {"cfdp_pdu_crc", {FieldType::u8, false}},
    {"cfdp_segment_bytes", {FieldType::u16, false}},
    {"cfdp_metadata_copies", {FieldType::u8, false}},
    {"cfdp_open_transfers", {FieldType::u8, false}},
    {"cfdp_timer_limit", {FieldType::u16, false}},
    {"cfdp_queue_kib", {FieldType::u32, false}},
    {"apid", {FieldType::u16, true}},
    {"telecommands_per_s", {FieldType::u16, false}},
    {"authentication", {FieldType::u8, false}},
    {"tailoring", {FieldType::u8, true}},
    {"cuc_time", {FieldType::u8, true}},
    {"mission_epoch_s", {FieldType::f64, true}},
    {"agency_epoch_s", {FieldType::u32, true}},
    {"seed", {FieldType::u32, true}},
    {"safe_mode", {FieldType::u8, false}},
    {"degraded_modes", {FieldType::u8, false}},
    {"overload_frames", {FieldType::u32, false}},
    {"overload_keyframes", {FieldType::u16, false}},
    {"recovery_windows", {FieldType::u16, false}},
};

constexpr double minor_frame_s = 1e-9 * static_cast<double>(minor_frame_ns);

double& value_at(MissionParameters& mission, const ParameterInfo& info) {
  return *reinterpret_cast<double*>(reinterpret_cast<unsigned char*>(&mission) + info.offset);
}

}  // namespace

std::size_t parameter_count() {
  return std::size(infos);
}
const ParameterInfo& parameter_info(std::size_t index) {
  return infos[index];
}

ParameterLink parameter_link(std::size_t index) {
  for (const LinkRow& row : link_rows) {
    if (std::strcmp(row.key, infos[index].key) == 0) return row.link;
  }
  return {};
}

std::size_t find_parameter(std::uint64_t number) {
  std::size_t i = 0;
  while (i < std::size(infos) && infos[i].number != number) ++i;
  return i;
}

std::size_t find_parameter(const char* section, const char* key) {
  std::size_t i = 0;
  while (i < std::size(infos) && (std::strcmp(infos[i].section, section) != 0 || std::strcmp(infos[i].key, key) != 0)) {
    ++i;
  }
  return i;
}

double parameter_value(const MissionParameters& mission, std::size_t index) {
  double value = 0;
  std::memcpy(&value, reinterpret_cast<const unsigned char*>(&mission) + infos[index].offset, sizeof(value));
  return value;
}

Status set_parameter(MissionParameters& mission, std::size_t index, double value) {
  if (index >= std::size(infos)) return {StatusCode::not_found, static_cast<std::int64_t>(index)};
  const ParameterInfo& info = infos[index];
  if (!(value >= info.minimum && value <= info.maximum)) {
    return {StatusCode::invalid_argument, static_cast<std::int64_t>(index)};
  }
  value_at(mission, info) = value;
  return {};
}

Status set_parameter(MissionParameters& mission, const char* section, const char* key, double value) {
  const std::size_t index = find_parameter(section, key);
  return index < std::size(infos) ? set_parameter(mission, index, value) : Status{StatusCode::not_found};
}

Status validate(const MissionParameters& mission) {
  if (mission.min_overlap >= mission.target_overlap) return {StatusCode::invalid_argument, 1};
  if (mission.image_bpp_floor > mission.image_bpp_ceiling) return {StatusCode::invalid_argument, 2};
  if (mission.depth_bpp_floor > mission.depth_bpp_ceiling) return {StatusCode::invalid_argument, 3};
  if (mission.capture_mode != 0 && mission.capture_mode != 1 && mission.capture_mode != 2) {
    return {StatusCode::invalid_argument, 5};
  }
  if (mission.capture_safe_interval_s < mission.capture_min_interval_s ||
      mission.capture_max_interval_s < mission.capture_safe_interval_s) {
    return {StatusCode::invalid_argument, 6};
  }
  if (mission.pass_period_s > 0 && mission.pass_length_s > mission.pass_period_s) {
    return {StatusCode::invalid_argument, 7};
  }
  if (mission.low_watermark >= mission.high_watermark) return {StatusCode::invalid_argument, 8};
  const double weights = mission.gradient_fine_weight + mission.gradient_coarse_weight + mission.entropy_weight +
                         mission.contrast_weight + mission.relief_weight + mission.slope_steep_weight +
                         mission.slope_excess_weight + mission.roughness_fine_weight + mission.roughness_coarse_weight +
                         mission.curvature_weight + mission.novelty_weight;
  if (!(weights > 0)) return {StatusCode::invalid_argument, 9};
  const double octets = mission.cfdp_sequence_octets;
  if (octets != 1 && octets != 2 && octets != 4 && octets != 8) return {StatusCode::invalid_argument, 10};
  const double checksum = mission.cfdp_checksum;
  if (checksum != 0 && checksum != 2 && checksum != 3 && checksum != 15) return {StatusCode::invalid_argument, 11};
  if (mission.window_keyframes == 1 || mission.window_keyframes == 2) return {StatusCode::invalid_argument, 4};
  for (const double interval_s : {mission.capture_interval_s, mission.housekeeping_period_s, mission.cfdp_prompt_s,
                                  mission.confirmation_timeout_s}) {
    if (interval_s != 0 && interval_s < minor_frame_s) return {StatusCode::invalid_argument, 12};
  }
  if (mission.capture_interval_s != 0 && mission.capture_interval_s < mission.capture_min_interval_s) {
    return {StatusCode::invalid_argument, 13};
  }
  return {};
}

std::uint32_t window_length(const MissionParameters& mission) {
  constexpr auto longest = static_cast<std::uint32_t>(limits::max_window_keyframes);
  if (mission.window_keyframes >= 3) return static_cast<std::uint32_t>(mission.window_keyframes);
  const double derived = std::ceil(1.0 / (1.0 - mission.target_overlap) - 1e-9);
  const double bounded = derived < 5 ? 5 : derived;
  return bounded > longest ? longest : static_cast<std::uint32_t>(bounded);
}

}  // namespace ilp
