// The executive's table: which component runs when, for how long, what wakes it, what it reads and writes. This is also
// the life of an image on one page.
#pragma once

#include <cstdint>

#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

enum class ComponentId : std::uint8_t {
  telecommander,
  capture_clock,
  acquisition,
  overlap_checker,
  camera_calibrator,
  structure_and_motion,
  dense_matcher,
  richness_scorer,
  compressor,
  storage_manager,
  downlink,
  file_delivery,
  telecommand_guard,
  telemetry,
  scrubber,
  count
};

struct Stage {
  ComponentId component;
  const char* name;
  RecordMask reads;  ///< what it is woken by
  RecordMask writes;
  std::uint32_t period;  ///< runs every so many minor frames even when nothing woke it; 0 only when woken
  TimeNs budget_ns;      ///< processor time of one step; longer is an overrun
};

inline constexpr TimeNs minor_frame_ns = 100 * ns_per_ms;
/// Bound on the steps of one minor frame; in virtual time the only one.
inline constexpr std::uint32_t max_steps_per_frame = 20'000;
/// A component that reports so many faults without a good step between waits for the next minor frame.
inline constexpr std::uint32_t max_faults_in_a_row = 32;
/// A component that found the store full tries again after so many minor frames: its work is repeated each time.
inline constexpr std::int64_t full_store_retry_frames = 50;
/// After a fault that may pass a component is tried again in the next minor frame, then after 2, 4, ... up to so many.
inline constexpr std::int64_t longest_pause_frames = 64;
/// An input that cannot be read for such a fault is tried so often, within 70 s, before that becomes a verdict on it.
inline constexpr std::uint32_t most_read_attempts = 16;

inline constexpr Stage schedule[] = {
    // Time-driven: first, so that what is commanded is done within the same minor frame.
    {ComponentId::telecommander, "telecommander", 0,
     mask_of(RecordType::command, RecordType::setting, RecordType::scheduled, RecordType::commanding), 1,
     10 * ns_per_ms},
    // Time-driven: decides when the next image is wanted; asks the camera in every minor frame.
    {ComponentId::capture_clock, "capture_clock",
     mask_of(RecordType::frame, RecordType::overlap, RecordType::keyframe, RecordType::pose, RecordType::command),
     mask_of(RecordType::capture), 1, 5 * ns_per_ms},
    {ComponentId::acquisition, "acquisition", mask_of(RecordType::capture),
     mask_of(RecordType::frame, RecordType::capture, RecordType::command), 1, 20 * ns_per_ms},
    {ComponentId::overlap_checker, "overlap_checker", mask_of(RecordType::frame, RecordType::command),
     mask_of(RecordType::overlap, RecordType::strip, RecordType::keyframe), 0, 20 * ns_per_ms},
    // Finds an unknown camera, then checks each strip against the camera.
    {ComponentId::camera_calibrator, "camera_calibrator",
     mask_of(RecordType::keyframe, RecordType::strip, RecordType::pose),
     mask_of(RecordType::camera, RecordType::calibration, RecordType::calibration_check), 0, 100 * ns_per_ms},
    {ComponentId::structure_and_motion, "structure_and_motion",
     mask_of(RecordType::keyframe, RecordType::strip, RecordType::camera, RecordType::calibration),
     mask_of(RecordType::pose, RecordType::structure, RecordType::command), 0, 50 * ns_per_ms},
    {ComponentId::dense_matcher, "dense_matcher", mask_of(RecordType::pose, RecordType::setting),
     mask_of(RecordType::depth), 0, 50 * ns_per_ms},
    {ComponentId::richness_scorer, "richness_scorer", mask_of(RecordType::depth, RecordType::setting),
     mask_of(RecordType::richness), 0, 50 * ns_per_ms},
    {ComponentId::compressor, "compressor", mask_of(RecordType::richness, RecordType::setting),
     mask_of(RecordType::product), 0, 100 * ns_per_ms},
    // Now and then unasked: frames that nobody looks at wake nobody.
    {ComponentId::storage_manager, "storage_manager",
     mask_of(RecordType::product, RecordType::downlink, RecordType::overlap, RecordType::command),
     mask_of(RecordType::storage, RecordType::frame, RecordType::depth, RecordType::structure, RecordType::product), 50,
     20 * ns_per_ms},
    // Time-driven too: the link carries so many bytes a second, and confirmations come when they come.
    {ComponentId::downlink, "downlink", mask_of(RecordType::richness, RecordType::product, RecordType::component),
     mask_of(RecordType::downlink, RecordType::product), 5, 20 * ns_per_ms},
    // Time-driven: the link is read and filled in every minor frame.
    {ComponentId::file_delivery, "file_delivery", 0, mask_of(RecordType::transfer, RecordType::uplink), 1,
     20 * ns_per_ms},
    // Time-driven: what was authenticated waits for it.
    {ComponentId::telecommand_guard, "telecommand_guard", 0, 0, 1, 5 * ns_per_ms},
    // Time-driven: behind all who work, so that it tells what the minor frame has brought.
    {ComponentId::telemetry, "telemetry", mask_of(RecordType::event), 0, 1, 10 * ns_per_ms},
    // Time-driven: reads through what is stored and what is in memory, a little at a time.
    {ComponentId::scrubber, "scrubber", 0, 0, 10, 10 * ns_per_ms},
};

inline constexpr std::size_t stage_count = sizeof(schedule) / sizeof(schedule[0]);
static_assert(stage_count == static_cast<std::size_t>(ComponentId::count), "every component has one stage");
constexpr bool schedule_in_order() {
  for (std::size_t i = 0; i < stage_count; ++i) {
    if (static_cast<std::size_t>(schedule[i].component) != i) return false;
  }
  return true;
}
static_assert(schedule_in_order(), "a component's number is its place in the schedule");

}  // namespace ilp
