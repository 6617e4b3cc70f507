// The records that components exchange through the store: one plain struct per record of fsw/records/records.inc. The
// life of an image runs through them:
// Frame -> Keyframe -> Pose (provisional, then final) -> Depth + Mask -> Richness -> Product -> Acknowledged.
#pragma once

#include <cstdint>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"
#include "fsw/records/words.hpp"

namespace ilp {

inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

#define SCHEMA(version) inline constexpr std::int32_t schema_version = version;
#include "fsw/records/rows_as_structs.inc"
// The rows.
#include "fsw/records/records.inc"

inline constexpr std::int64_t camera_id = 1, nominal_camera_id = 2, camera_copy_id = 3;

/// The blob `points` of the record `structure` is a sequence of StructurePoint, each followed by `observations`
/// StructureObservation.
struct StructurePoint {
  double position[3];
  float error_px;
  std::uint32_t observations;
};
struct StructureObservation {
  std::int64_t keyframe_id;
  float x, y;  ///< px of the real image, pixel centres at integers
};

/// The blob `points` of the record `fix` is a sequence of FixPoint: a patch's place in the keyframe, ideal px in units
/// of 1 / fix_points_per_px from (-fix_point_margin_px, -fix_point_margin_px), and in the window, working px in units
/// of 1 / fix_window_points_per_px.
struct FixPoint {
  std::uint16_t u, v, column, row;
};
inline constexpr double fix_points_per_px = 16;
inline constexpr double fix_point_margin_px = 512;
inline constexpr double fix_window_points_per_px = 256;

/// The blob `points` of the record `link` is a sequence of LinkPoint: the same point of the ground in the earlier and
/// in the newer keyframe, px of the real images in units of 1 / link_points_per_px.
struct LinkPoint {
  std::uint16_t place_x, place_y, x, y;
};
inline constexpr double link_points_per_px = 32;

[[nodiscard]] constexpr std::int64_t product_id(std::int64_t keyframe_id, ProductKind kind) {
  return 4 * keyframe_id + static_cast<std::int64_t>(kind);
}

[[nodiscard]] constexpr std::int64_t link_id(std::int64_t keyframe_id, std::int64_t number) {
  return limits::max_links_per_keyframe * keyframe_id + number;
}

/// Whether the pair of a pose measured the scale. A measured step is a quotient of distances and never exactly 1.
[[nodiscard]] constexpr bool scale_step_measured(const PoseRecord& pose) {
  return pose.scale_step < 1 || pose.scale_step > 1;
}

template <typename Record>
[[nodiscard]] const RecordInfo& record_info();

/// The table of all records, in the order of RecordType.
[[nodiscard]] const RecordInfo& record_info(RecordType type);

[[nodiscard]] CameraModel camera_model(const CameraRecord& record);
/// Frozen, given as exact.
[[nodiscard]] CameraRecord camera_record(const CameraModel& camera);
/// Whether the flight has to know how images move while they are read.
[[nodiscard]] constexpr bool has_rolling_shutter(const CameraRecord& camera) {
  return camera.sigma_readout_s > 0 || camera.readout_s < 0 || camera.readout_s > 0;
}
/// Not frozen, with unknown errors.
[[nodiscard]] CameraRecord nominal_camera_record(const CameraModel& camera);
[[nodiscard]] Pose pose_of(const PoseRecord& record);

}  // namespace ilp
