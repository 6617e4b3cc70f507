// The records that components exchange through the store: one plain struct per record of fsw/records/records.inc. An
// image leads to these records in turn:
// Frame -> Keyframe -> Pose (provisional, then final) -> Depth + Mask -> Richness -> Product (then acknowledged).
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
  double position[3];  ///< in the strip's world frame, strip units
  float error_px;
  std::uint32_t observations;  ///< number of observations that follow
};
struct StructureObservation {
  std::int64_t keyframe_id;
  float x, y;  ///< px of the real image, pixel centres at integers
};

/// The blob `points` of the record `fix` is a sequence of FixPoint: the position of a patch in the keyframe (u, v) and
/// in the map window (column, row). u and v are ideal px in units of 1 / fix_points_per_px, counted from
/// (-fix_point_margin_px, -fix_point_margin_px). column and row are working px in units of 1 /
/// fix_window_points_per_px.
struct FixPoint {
  std::uint16_t u, v, column, row;
};
inline constexpr double fix_points_per_px = 16;
inline constexpr double fix_point_margin_px = 512;
inline constexpr double fix_window_points_per_px = 256;

/// The blob `points` of the record `link` is a sequence of LinkPoint: the position of the same ground point in the
/// earlier keyframe (place_x, place_y) and in the newer one (x, y), px of the real images in units of 1 /
/// link_points_per_px.
struct LinkPoint {
  std::uint16_t place_x, place_y, x, y;
};
inline constexpr double link_points_per_px = 32;

/// The id of a keyframe's product of a kind.
[[nodiscard]] constexpr std::int64_t product_id(std::int64_t keyframe_id, ProductKind kind) {
  return 4 * keyframe_id + static_cast<std::int64_t>(kind);
}

/// The id of a keyframe's link; `number` is below limits::max_links_per_keyframe.
[[nodiscard]] constexpr std::int64_t link_id(std::int64_t keyframe_id, std::int64_t number) {
  return limits::max_links_per_keyframe * keyframe_id + number;
}

/// Whether the scale of a pose was measured by its pair. A measured step is a ratio of distances and never exactly 1.
[[nodiscard]] constexpr bool scale_step_measured(const PoseRecord& pose) {
  return pose.scale_step < 1 || pose.scale_step > 1;
}

template <typename Record>
[[nodiscard]] const RecordInfo& record_info();

/// The table of all records, in the order of RecordType.
[[nodiscard]] const RecordInfo& record_info(RecordType type);

[[nodiscard]] CameraModel camera_model(const CameraRecord& record);
/// The record of a camera that is given as exact: frozen, without errors.
[[nodiscard]] CameraRecord camera_record(const CameraModel& camera);
/// Whether the camera exposes its rows one after the other, or may do so.
[[nodiscard]] constexpr bool has_rolling_shutter(const CameraRecord& camera) {
  return camera.sigma_readout_s > 0 || camera.readout_s < 0 || camera.readout_s > 0;
}
/// The record of a nominal camera: not frozen, with unknown errors.
[[nodiscard]] CameraRecord nominal_camera_record(const CameraModel& camera);
[[nodiscard]] Pose pose_of(const PoseRecord& record);

}  // namespace ilp
