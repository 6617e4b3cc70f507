// What the components say to each other: one plain struct per record. The life of an image runs through them:
// Frame -> Keyframe -> Pose (provisional, then final) -> Depth + Mask -> Richness -> Product -> Acknowledged.
#pragma once

#include <cstdint>
#include <limits>

#include "cfg/limits.hpp"
#include "fsw/base/geometry.hpp"
#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

inline constexpr std::int32_t schema_version = 7;
inline constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Id 1: the camera; nothing metric is computed before it is frozen, and it never changes afterwards (decisions.md, 6).
/// Id 2: only where the intrinsics were not known, the nominal ones that the flight was begun with. Id 3: a copy of the
/// first, for where that one is damaged.
struct CameraRecord {
  std::int64_t id = 1;
  std::int32_t width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  std::uint8_t frozen = 0;
  double sigma_focal_px = 0, sigma_cx_px = 0, sigma_cy_px = 0;
};
inline constexpr std::int64_t camera_id = 1, nominal_camera_id = 2, camera_copy_id = 3;

/// What speaks against a frame's time stamp.
enum class TimeDoubt : std::uint8_t {
  none,
  off_command,  ///< not when the exposure was commanded
  off_period,   ///< not where the camera's counter and period put it
  count
};

/// An image as the camera gave it. Ids count from 1 in order of arrival.
struct FrameRecord {
  std::int64_t id = 0;
  TimeNs time_ns = 0;
  std::int64_t sequence = 0;
  std::int32_t width = 0, height = 0;
  double altitude = unknown;
  std::int64_t capture_id = 0;
  TimeDoubt time_doubt = TimeDoubt::none;
  char name[64] = {};
  Blob image;
};

enum class CaptureSource : std::uint8_t {
  regular,      ///< a constant interval
  forecast,     ///< when the overlap will have fallen to its target
  on_the_way,   ///< before that, because the forecast's error is large
  safe,         ///< nothing is known of the motion
  telecommand,  ///< the ground asked for this time
  count
};
enum class CaptureState : std::uint8_t { pending, exposed, no_frame, rejected, superseded, count };

/// A time at which an image is wanted, and what became of it: exactly one frame, or the reason why there is none. Ids
/// count from 1.
struct CaptureRecord {
  std::int64_t id = 0;
  TimeNs requested_ns = 0;
  TimeNs issued_ns = 0;
  CaptureSource source = CaptureSource::regular;
  CaptureState state = CaptureState::pending;
  std::int64_t command_id = 0;
  std::int64_t frame_id = 0;
  TimeNs exposed_ns = 0;
  double overlap = unknown;
  double overlap_sigma = unknown;
  double speed_px_s = unknown;
  std::uint16_t reason = 0;  ///< StatusCode, of a rejected one, or of one whose nearest frame was too far off
};

/// The overlap checker's answer to one frame; the id is the frame's.
struct OverlapRecord {
  std::int64_t id = 0;
  std::int64_t keyframe_id = 0;
  std::uint8_t verdict = 0;
  std::uint8_t decision = 0;
  double overlap = 0;
  double scale = 1, rotation_rad = 0, shift_x_px = 0, shift_y_px = 0;
  double ncc = 0, ncc_second = 0, sigma_px = 0;
};
enum class OverlapDecision : std::uint8_t { skipped, selected, new_strip, rejected, count };

enum class StripEnd : std::uint8_t { open, overlap_lost, overlap_unknown, pose_lost, end_of_flight, commanded, count };
enum class ScaleSource : std::uint8_t { first_baseline, altimeter, count };

/// A run of keyframes with one origin and one scale.
struct StripRecord {
  std::int64_t id = 0;
  std::int64_t first_keyframe_id = 0;
  std::int64_t last_keyframe_id = 0;
  StripEnd end = StripEnd::open;
};

/// A frame selected for processing. Ids count from 1; `from_previous` maps the previous keyframe's pixels to this
/// one's.
struct KeyframeRecord {
  std::int64_t id = 0;
  std::int64_t frame_id = 0;
  std::int64_t strip_id = 0;
  std::int32_t index = 0;
  TimeNs time_ns = 0;
  double overlap = 0;
  double plane_from_previous[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  double altitude = unknown;
  std::uint8_t degraded = 0;  ///< level of reduced work that everything of it is computed at, 0: full
};

/// What self-calibration said at a keyframe of a flight whose camera was not known; the id is the keyframe's. There is
/// none behind the one that says ok.
struct CalibrationRecord {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  std::uint8_t verdict = 0;
  std::uint32_t views = 0;
  std::uint32_t matches = 0, inliers = 0;
  double gric_f = 0, gric_h = 0;
  double motion_px = 0;
  std::uint32_t points = 0;
  double focal_px = 0, sigma_px = 0;
  double axes_spread_rad = 0;
  double noise_px = 0;
  double consistency = 0;
};

enum class PoseState : std::uint8_t { provisional, final, failed, count };

/// Where a keyframe was taken; the id is the keyframe's. Immutable once final.
struct PoseRecord {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  PoseState state = PoseState::provisional;
  std::uint8_t verdict = 0;
  ScaleSource scale_source = ScaleSource::first_baseline;
  double q_cam_from_world[4] = {1, 0, 0, 0};
  double centre[3] = {0, 0, 0};
  double sigma[3] = {0, 0, 0};
  std::uint32_t matches = 0, pair_inliers = 0, known_points = 0, inliers = 0, points = 0;
  double rms_px = 0;
  double gric_f = 0, gric_h = 0;
  double parallax_px = 0;
  double sigma_rotation_rad = 0, sigma_direction_rad = 0;
  double scale_step = 1;
  std::uint8_t two_view_verdict = 0;
  double min_depth = 0, max_depth = 0;
  double step_covariance[21] = {};  ///< StepCovariance of fsw/vision/stereo/pose_error.hpp
  double covariance[21] = {};       ///< SequenceCamera::covariance of fsw/vision/multiview/sequence.hpp
};

/// Points of the structure that became final together with a keyframe's pose; the id is the keyframe's. The blob is a
/// sequence of StructurePoint, each followed by `observations` StructureObservation.
struct StructureRecord {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  std::uint32_t count = 0;
  Blob points;
};
struct StructurePoint {
  double position[3];
  float error_px;
  std::uint32_t observations;
};
struct StructureObservation {
  std::int64_t keyframe_id;
  float x, y;  ///< px of the real image, pixel centres at integers
};

/// id = 2 * strip for its first keyframes, 2 * strip + 1 for its last ones.
[[nodiscard]] constexpr std::int64_t calibration_check_id(std::int64_t strip_id, bool at_end) {
  return 2 * strip_id + (at_end ? 1 : 0);
}

/// Whether final poses and points of a strip agree with the camera's focal length.
struct CalibrationCheckRecord {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  std::int64_t first_keyframe_id = 0, last_keyframe_id = 0;
  std::uint8_t verdict = 0;
  std::uint32_t views = 0, points = 0;
  double focal_px = 0, sigma_px = 0;
  double deviation = 0;
  double noise_px = 0;
  double consistency = 0;
};

enum class DepthVerdict : std::uint8_t { ok, no_partner, rectification_impossible, too_few_valid, count };

/// Inverse depth of a keyframe in its own pixel grid; the id is the keyframe's. inverse_depth = offset + step * value
/// for values from 1; 0 is invalid.
struct DepthRecord {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  std::int64_t partner_id = 0;
  DepthVerdict verdict = DepthVerdict::ok;
  std::int32_t width = 0, height = 0;
  double offset = 0, step = 0;
  double baseline = 0;
  double disparity_per_inverse_depth_px = 0;
  double epipole_x = 0, epipole_y = 0;
  double blind_radius_px = 0;
  double pose_sigma = 0;
  std::uint32_t valid = 0, newly_seen = 0;
  double median_sigma_px = 0;
  Blob values;
  Blob sigma;
  Blob mask;
};

/// How interesting the newly seen part of a keyframe is (decisions.md, 10); the id is the keyframe's.
struct RichnessRecord {
  std::int64_t id = 0;
  std::int64_t strip_id = 0;
  double richness = 0;
  double gradient_fine = 0, gradient_coarse = 0, entropy = 0, contrast = 0;
  double relief = 0, slope_steep = 0, slope_excess = 0, roughness_fine = 0, roughness_coarse = 0, curvature = 0;
  double novelty = 0;
  double mask_fraction = 0;
  std::uint8_t has_terrain = 0;
  std::uint32_t images_learned = 0;
};

/// In the order in which they are made: when the image of a keyframe is there, its depth map is there if there is one.
enum class ProductKind : std::uint8_t { depth, image, count };
enum class ProductScheme : std::uint8_t { lossy_region, lossless_region, thumbnail, count };
enum class ProductState : std::uint8_t { stored, sent, acknowledged, dropped, count };

[[nodiscard]] constexpr const char* product_kind_name(ProductKind kind) {
  return kind == ProductKind::image ? "image" : "depth";
}

[[nodiscard]] constexpr std::int64_t product_id(std::int64_t keyframe_id, ProductKind kind) {
  return 4 * keyframe_id + static_cast<std::int64_t>(kind);
}

/// A coded image or depth map, a standard JP2 file. id = 4 * keyframe id + kind. It goes down in quality layers:
/// `stored` until the last of them has been handed to the link, `sent` until the ground has confirmed them all, then
/// `acknowledged`. The storage manager may take away layers beyond `layers_sent`.
/// layer_bytes[i] is the size of the file when cut after its layer i (truncate_to_layers), layer_quality[i] how well it
/// then shows the part newly seen (a thumbnail: the whole image): of an image the PSNR in dB, 120 when exact; of a
/// depth map the largest error of disparity in px, coding and rounding together. Both 0 beyond `layers`.
struct ProductRecord {
  std::int64_t id = 0;
  std::int64_t keyframe_id = 0;
  std::int64_t strip_id = 0;
  ProductKind kind = ProductKind::image;
  ProductScheme scheme = ProductScheme::lossy_region;
  ProductState state = ProductState::stored;
  double priority = 0;
  std::uint32_t grant_bytes = 0;
  std::uint32_t bytes = 0;
  std::uint32_t crc32 = 0;
  std::uint8_t layers = 0;
  std::uint32_t layer_bytes[limits::max_quality_layers] = {};
  float layer_quality[limits::max_quality_layers] = {};
  std::uint8_t layers_sent = 0;  ///< the first so many have been handed to the link
  std::uint8_t layers_held = 0;  ///< bit k: the ground has confirmed layer k + 1
  Blob data;
};

enum class DownlinkKind : std::uint8_t { product, records, points, count };

/// A file that was handed to the link, and whether the ground holds it. Ids count from 1.
struct DownlinkRecord {
  std::int64_t id = 0;
  DownlinkKind kind = DownlinkKind::product;
  std::int64_t subject_id = 0;
  std::uint32_t bytes = 0;
  std::uint32_t crc32 = 0;
  TimeNs sent_ns = 0;
  TimeNs acknowledged_ns = 0;
  std::int64_t records_through = 0, points_through = 0;
  std::uint8_t first_layer = 0, last_layer = 0;  ///< of a product, from 1
  char name[32] = {};
};

/// What the store holds and what was given up, since the flight began. One record, id 1.
struct StorageRecord {
  std::int64_t id = 1;
  std::int64_t frame_bytes = 0, depth_bytes = 0, structure_bytes = 0, product_bytes = 0;
  std::uint32_t frames_held = 0, depths_held = 0, structures_held = 0, products_held = 0;
  std::int64_t budget_bytes = 0;
  std::uint8_t full = 0;
  std::uint32_t times_full = 0;
  TimeNs oldest_age_ns = 0;
  std::uint32_t frames_released = 0;
  std::uint32_t frames_skipped = 0;
  std::uint32_t layers_cut = 0, products_dropped = 0, products_damaged = 0, products_acknowledged = 0;
  std::uint32_t structures_dropped = 0, files_lost = 0;
  std::int64_t skipped_bytes = 0, cut_bytes = 0, dropped_bytes = 0, acknowledged_bytes = 0;
  std::int64_t rows_erased = 0;
  std::int64_t database_bytes = 0, database_free_bytes = 0;
};

enum class CommandKind : std::uint8_t {
  end_strip,
  capture,         ///< at a time, which must not be past
  refine,          ///< a keyframe's products go before others
  capture_soon,    ///< at a time, or at once where it is past
  delete_product,  ///< given up by the ground
  restart,         ///< a component goes back to its checkpoint
  count
};

/// What was commanded, from the ground or by a component that cannot go on. Ids count from 1.
struct CommandRecord {
  std::int64_t id = 0;
  TimeNs time_ns = 0;
  CommandKind kind = CommandKind::end_strip;
  StripEnd reason = StripEnd::commanded;
  std::int64_t after_frame_id = 0;
  TimeNs at_ns = 0;
  std::int64_t keyframe_id = 0;
  std::int64_t subject_id = 0;  ///< product or component
  std::int64_t request_id = 0;  ///< of the telecommand that it comes from; 0: none
  std::int64_t tag = 0;         ///< the ground's own mark on a capture
};

/// Something worth telling. Ids count from 1.
struct EventRecord {
  std::int64_t id = 0;
  TimeNs time_ns = 0;
  std::uint16_t code = 0;
  std::uint8_t severity = 0;
  char component[24] = {};
  std::int64_t a = 0, b = 0;
  char place[48] = {};
};

/// A component's health and use of time; the id is its number in cfg/schedule.hpp. Written at the end of a flight and
/// with housekeeping.
struct ComponentRecord {
  std::int64_t id = 0;
  char name[24] = {};
  std::uint32_t steps = 0, overruns = 0, restarts = 0, faults = 0;
  std::int64_t busy_ns = 0, longest_ns = 0;
};

/// Where a component continues after a restart; the id is its number in cfg/schedule.hpp.
struct CheckpointRecord {
  std::int64_t id = 0;  ///< number in the schedule; 100 more: the other one of two
  std::int64_t cursor = 0;
  std::int64_t cursor_second = 0;
  std::int64_t generation = 0;
  std::int64_t checksum = 0;
  std::uint32_t layout = 0;
  Blob state;
};

enum class TransferState : std::uint8_t {
  waiting,    ///< none of it has gone
  sending,    ///< some has
  sent,       ///< all has gone once; gaps are filled until the ground says that it has the file
  delivered,  ///< the ground holds it, whole and checked
  count
};
/// What the ground wants of a transfer.
enum class TransferWish : std::uint8_t { none, suspend, resume, cancel, count };

/// A file on its way to the ground by CFDP (docs/file-delivery.md). Ids grow; a file that nobody waits for any more has
/// no record. `data` is the file until it is delivered, `gaps` pairs of u32 (begin, end) that the ground has asked for.
struct TransferRecord {
  std::int64_t id = 0;
  char name[32] = {};
  TransferState state = TransferState::waiting;
  TransferWish wish = TransferWish::none;
  std::uint8_t suspended = 0;
  std::uint8_t priority = 0;  ///< 0 goes first
  std::uint32_t bytes = 0;
  std::uint32_t crc32 = 0;
  std::uint8_t checksum_type = 0;
  std::uint32_t checksum = 0;
  std::int64_t sequence = 0;
  std::int64_t destination = 0;
  std::uint32_t progress = 0;
  std::uint32_t resent_bytes = 0;
  std::uint32_t attempts = 0;
  std::uint8_t condition = 0;
  TimeNs queued_ns = 0;
  TimeNs delivered_ns = 0;
  Blob data;
  Blob gaps;
};

enum class UplinkState : std::uint8_t { checked, rejected, active, superseded, count };

/// A file that has come from the ground, whole and with the right checksum. Ids count from 1.
struct UplinkRecord {
  std::int64_t id = 0;
  char name[64] = {};
  UplinkState state = UplinkState::checked;
  std::uint16_t fault = 0;  ///< StatusCode, why it was rejected
  std::int64_t fault_place = 0;
  std::int64_t source = 0;
  std::int64_t sequence = 0;
  std::uint32_t crc32 = 0;
  TimeNs received_ns = 0;
  TimeNs activated_ns = 0;
  Blob data;
};

/// A mission parameter that the ground has set; the id is the parameter's number in docs/parameters.md.
struct SettingRecord {
  std::int64_t id = 0;
  char name[64] = {};  ///< section.key
  double value = 0;
  TimeNs set_ns = 0;
};

/// A telecommand that waits for its time. Ids count from 1.
struct ScheduledRecord {
  std::int64_t id = 0;
  TimeNs release_ns = 0;
  std::uint16_t source = 0, apid = 0, count = 0;  ///< how service 11 names it
  std::uint32_t sub_schedule = 0, group = 0;
  std::uint8_t ahead = 0;  ///< a capture: given to the camera before its time
  Blob packet;
};

/// Telecommands and reports since the flight began. One record, id 1.
struct CommandingRecord {
  std::int64_t id = 1;
  std::uint32_t received = 0, accepted = 0, rejected = 0, unanswerable = 0;
  std::uint32_t completed = 0, failed = 0;
  std::uint32_t open = 0, scheduled = 0;
  std::uint8_t schedule_enabled = 1;
  std::uint32_t reports_sent = 0, reports_lost = 0, reports_waiting = 0;
};

/// Why the software had to be started.
enum class StartReason : std::uint8_t {
  first,         ///< the store is new
  stopped,       ///< the life before had ended in order
  process_died,  ///< killed or crashed, on a board that went on
  board_reset,   ///< power was lost, or the board was reset
  watchdog,      ///< the board's watchdog had bitten
  count
};

/// One life of the software. Ids count from 1.
struct StartRecord {
  std::int64_t id = 0;
  TimeNs time_ns = 0;
  TimeNs alive_ns = 0;  ///< when it was last known to live
  TimeNs end_ns = 0;    ///< 0: not ended in order
  StartReason reason = StartReason::first;
  std::uint32_t tested = 0, failed = 0;  ///< bit k: self-test k
  std::uint32_t stack_bytes = 0;         ///< deepest use of the flight's stack
  std::uint32_t heap_traps = 0;          ///< requests for memory after start-up, refused
  std::uint32_t unconfirmed = 0;         ///< starts in a row before this one that no telecommand confirmed
  std::uint8_t configuration = 0;        ///< ConfigurationStage that it began with
  char version[24] = {};
  char board[40] = {};  ///< the board's own name for its boot
};

/// How minor frames keep their time, since the last start. Bin 0 of a histogram counts what is below 1 us, bin k what
/// is in [2^(k-1), 2^k) us; the last bin has no upper end. One record, id 1.
struct TimingRecord {
  std::int64_t id = 1;
  std::int64_t frames = 0;
  std::uint32_t overruns = 0;
  TimeNs longest_ns = 0;                         ///< minor frame, from its begin to its last step's end
  TimeNs latest_ns = 0;                          ///< begin of a minor frame behind its time
  std::uint32_t late[limits::timing_bins] = {};  ///< begins of minor frames behind their time
  std::uint32_t used[limits::timing_bins] = {};  ///< lengths of minor frames
  std::uint8_t degraded = 0;                     ///< level of reduced work, 0: full
  std::uint32_t degraded_changes = 0;
};

/// Which life of the flight the store belongs to: every new store of a flight is another one, and its numbers begin
/// behind those of the lives before. One record, id 1.
struct IdentityRecord {
  std::int64_t id = 1;
  std::int64_t life = 0;           ///< from 1
  std::int64_t keyframe_base = 0;  ///< keyframes, strips and event files count from the number behind it
  std::int64_t record_base = 0;    ///< all others likewise
  std::int64_t configuration = 0;  ///< grows with every change of the settings
};

template <typename Record>
[[nodiscard]] const RecordInfo& record_info();

/// The table of all records, in the order of RecordType.
[[nodiscard]] const RecordInfo& record_info(RecordType type);

[[nodiscard]] CameraModel camera_model(const CameraRecord& record);
/// Frozen, given as exact.
[[nodiscard]] CameraRecord camera_record(const CameraModel& camera);
/// Not frozen, with unknown errors.
[[nodiscard]] CameraRecord nominal_camera_record(const CameraModel& camera);
[[nodiscard]] Pose pose_of(const PoseRecord& record);

}  // namespace ilp
