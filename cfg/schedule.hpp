// The executive's table: for each component when it runs, its processor time, and which tables wake it and which it
// reads and writes. The order of its rows is the order in which the data of an image flow.
#pragma once

#include <cstdint>

#include "fsw/base/time.hpp"
#include "fsw/records/field.hpp"

namespace ilp {

/// The number of a component on the link and in stores (tests/unit/cfg/numbers.txt). The number of a removed component
/// is never used again.
enum class ComponentId : std::uint8_t {
  none,  ///< the executive, or the start of the flight
  telecommander = 1,
  capture_clock = 2,
  acquisition = 3,
  overlap_checker = 4,
  camera_calibrator = 5,
  structure_and_motion = 6,
  dense_matcher = 7,
  richness_scorer = 8,
  compressor = 9,
  storage_manager = 10,
  downlink = 11,
  file_delivery = 12,
  telecommand_guard = 13,
  telemetry = 14,
  scrubber = 15,
  navigator = 16,
  place_memory = 17,
  map_fix = 18,
};

/// What happens to a checkpoint whose state has another layout or size than this build's.
enum class OldState : std::uint8_t {
  refused,  ///< the flight does not begin with such a store (`store_build`)
  dropped   ///< the component starts without it
};

/// The process that may run a stage when several share the flight (docs/several-machines.md).
enum class RunsOn : std::uint8_t {
  any,     ///< it needs nothing but the store
  primary  ///< it needs the camera, a link, or the memory of the process that has the camera and the links
};

/// The layout numbers of a component's checkpoint states. A number is raised when the meaning of the state changes.
struct StateLayout {
  std::uint32_t number = 0;
  std::uint32_t second = 0;  ///< layout of another kind of state, which the component may have instead; 0: none
  OldState old = OldState::refused;
};

/// A row of the table: a component of the flight. Its position in the order of steps, its access to the store (enforced
/// by the compiler, fsw/executive/stage_component.hpp), its checkpoints and its pages follow from the row.
struct Stage {
  ComponentId component = ComponentId::none;
  const char* name = "";
  const char* page = "";   ///< folder of fsw whose design.md describes it
  RecordMask wakes = 0;    ///< a change of these tables wakes it
  RecordMask reads = 0;    ///< in addition to those that it writes, changes or erases
  RecordMask writes = 0;   ///< it makes records of these tables
  RecordMask changes = 0;  ///< it replaces records that another component has made
  RecordMask erases = 0;
  std::uint32_t period = 0;  ///< minor frames after which it runs without being woken; 0: it runs only when woken
  TimeNs budget_ns = 0;      ///< processor time of one step; a longer step counts as an overrun
  bool step_memory = false;  ///< it uses the memory that stages share (fsw/shared/step_memory.hpp)
  StateLayout state = {};
  RunsOn runs_on = RunsOn::any;
};

inline constexpr TimeNs minor_frame_ns = 100 * ns_per_ms;
/// Most steps in one minor frame. In virtual time there is no other bound.
inline constexpr std::uint32_t max_steps_per_frame = 20'000;
/// After this number of faults without a successful step in between, a component waits for the next minor frame.
inline constexpr std::uint32_t max_faults_in_a_row = 32;
/// Minor frames after which a component that found the store full tries again. Each attempt repeats its work.
inline constexpr std::int64_t full_store_retry_frames = 50;
/// The longest pause, in minor frames, after a transient fault of a component. The pause is 1 minor frame at first and
/// doubles with each further fault.
inline constexpr std::int64_t longest_pause_frames = 64;
/// Most attempts, within 70 s, to read an input with transient faults before the input gets a verdict.
inline constexpr std::uint32_t most_read_attempts = 16;

namespace stage_rows {
using enum RecordType;

inline constexpr RecordMask every_table = mask_of(count) - 1;

// In the order in which data flow, which is also the order of steps.
inline constexpr Stage rows[] = {
    // The first stages are driven by time, so that a command takes effect within the same minor frame.
    {.component = ComponentId::telecommander,
     .name = "telecommander",
     .page = "commanding",
     .reads = mask_of(capture, event, frame, pose, product, strip),
     .writes = mask_of(command, setting, scheduled, commanding),
     .changes = mask_of(transfer, uplink),
     .erases = mask_of(scheduled),
     .period = 1,
     .budget_ns = 10 * ns_per_ms,
     .state = {.number = 1},
     .runs_on = RunsOn::primary},
    // Decides when the next image is wanted, and asks the camera in every minor frame.
    {.component = ComponentId::capture_clock,
     .name = "capture_clock",
     .page = "imaging",
     .wakes = mask_of(frame, overlap, keyframe, pose, navigation, fix, command),
     .reads = mask_of(frame, overlap, keyframe, pose, navigation, fix, camera, command),
     .writes = mask_of(capture),
     .period = 1,
     .budget_ns = 5 * ns_per_ms,
     .state = {.number = 3},
     .runs_on = RunsOn::primary},
    {.component = ComponentId::acquisition,
     .name = "acquisition",
     .page = "imaging",
     .wakes = mask_of(capture),
     .reads = mask_of(overlap, keyframe),
     .writes = mask_of(frame, command),
     .changes = mask_of(capture),
     .period = 1,
     .budget_ns = 20 * ns_per_ms,
     .state = {.number = 2},
     .runs_on = RunsOn::primary},
    {.component = ComponentId::overlap_checker,
     .name = "overlap_checker",
     .page = "imaging",
     .wakes = mask_of(frame, command),
     .reads = mask_of(capture, frame, command, timing, camera),
     .writes = mask_of(overlap, strip, keyframe, frame_plane),
     .budget_ns = 20 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 2}},
    // Driven by time, because the vehicle's measurements arrive at any time.
    {.component = ComponentId::navigator,
     .name = "navigator",
     .page = "navigation",
     .wakes = mask_of(keyframe, pose, fix),
     .reads = mask_of(keyframe, pose, fix),
     .writes = mask_of(navigation, strip_frame),
     .period = 1,
     .budget_ns = 10 * ns_per_ms,
     .state = {.number = 2, .old = OldState::dropped},
     .runs_on = RunsOn::primary},
    // Finds an unknown camera; afterwards it checks each strip against the camera.
    {.component = ComponentId::camera_calibrator,
     .name = "camera_calibrator",
     .page = "motion",
     .wakes = mask_of(keyframe, strip, pose),
     .reads = mask_of(keyframe, strip, pose, structure, shutter, navigation),
     .writes = mask_of(camera, calibration, calibration_check),
     .budget_ns = 100 * ns_per_ms,
     .state = {.number = 4}},
    {.component = ComponentId::structure_and_motion,
     .name = "structure_and_motion",
     .page = "motion",
     .wakes = mask_of(keyframe, strip, overlap, camera, navigation),
     .reads = mask_of(keyframe, frame, strip, overlap, frame_plane, camera, navigation),
     .writes = mask_of(pose, structure, command, shutter),
     .erases = mask_of(structure),
     .budget_ns = 50 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 7}},
    {.component = ComponentId::dense_matcher,
     .name = "dense_matcher",
     .page = "terrain",
     .wakes = mask_of(pose, setting),
     .reads = mask_of(pose, strip, keyframe, frame, camera, shutter),
     .writes = mask_of(depth, mask),
     .budget_ns = 50 * ns_per_ms,
     .state = {.number = 3}},
    // Finds the ground of a keyframe on an orbiter's map. The primary has the files of the map.
    {.component = ComponentId::map_fix,
     .name = "map_fix",
     .page = "localisation",
     .wakes = mask_of(depth),
     .reads = mask_of(depth, keyframe, frame, camera, pose, shutter, navigation),
     .writes = mask_of(fix),
     .budget_ns = 20 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 1, .old = OldState::dropped},
     .runs_on = RunsOn::primary},
    // Runs between a keyframe's depth and all stages that use its mask, because it changes the mask.
    {.component = ComponentId::place_memory,
     .name = "place_memory",
     .page = "places",
     .wakes = mask_of(depth, setting),
     .reads = mask_of(depth, keyframe, frame, camera, pose, shutter),
     .writes = mask_of(place, link, tie),
     .changes = mask_of(mask),
     .erases = mask_of(place),
     .budget_ns = 50 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 2}},
    {.component = ComponentId::richness_scorer,
     .name = "richness_scorer",
     .page = "products",
     .wakes = mask_of(place, setting),
     .reads = mask_of(depth, mask, keyframe, frame, camera, shutter),
     .writes = mask_of(richness),
     .budget_ns = 50 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 2}},
    {.component = ComponentId::compressor,
     .name = "compressor",
     .page = "products",
     .wakes = mask_of(richness, setting),
     .reads = mask_of(richness, depth, mask, pose, keyframe, frame, camera, shutter),
     .writes = mask_of(product),
     .budget_ns = 100 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 2}},
    // It also runs without being woken, because frames that no other stage reads wake no stage.
    {.component = ComponentId::storage_manager,
     .name = "storage_manager",
     .page = "storage",
     .wakes = mask_of(product, downlink, overlap, command),
     .reads = mask_of(place),
     .writes = mask_of(storage),
     .changes = mask_of(frame, depth, mask, structure, product),
     .erases = mask_of(frame, capture, overlap, strip, keyframe, calibration, calibration_check, pose, structure, depth,
                       mask, richness, product, downlink, command, event, navigation, strip_frame, link, tie,
                       frame_plane, shutter, fix),
     .period = 50,
     .budget_ns = 20 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 3}},
    // Also driven by time, because the link has a rate in bytes per second, and confirmations come at any time.
    {.component = ComponentId::downlink,
     .name = "downlink",
     .page = "downlink",
     .wakes = mask_of(richness, product, component),
     .reads =
         mask_of(frame, overlap, strip, keyframe, camera, calibration, calibration_check, pose, structure, depth, mask,
                 richness, storage, command, event, component, start, timing, navigation, strip_frame, link, tie, fix),
     .writes = mask_of(downlink, transfer),
     .changes = mask_of(product),
     .erases = mask_of(downlink, transfer),
     .period = 5,
     .budget_ns = 20 * ns_per_ms,
     .step_memory = true,
     .state = {.number = 3},
     .runs_on = RunsOn::primary},
    // Driven by time: the link is read and filled in every minor frame.
    {.component = ComponentId::file_delivery,
     .name = "file_delivery",
     .page = "downlink",
     .writes = mask_of(uplink),
     .changes = mask_of(transfer),
     .erases = mask_of(transfer, uplink),
     .period = 1,
     .budget_ns = 20 * ns_per_ms,
     .state = {.number = 1},
     .runs_on = RunsOn::primary},
    // Driven by time: authenticated telecommands wait for it.
    {.component = ComponentId::telecommand_guard,
     .name = "telecommand_guard",
     .page = "commanding",
     .period = 1,
     .budget_ns = 5 * ns_per_ms,
     .state = {.number = 1},
     .runs_on = RunsOn::primary},
    // Reads all stored data and memory to find damage, a small part in each step.
    {.component = ComponentId::scrubber,
     .name = "scrubber",
     .page = "storage",
     .reads = every_table,
     .period = 10,
     .budget_ns = 10 * ns_per_ms,
     .state = {.number = 1, .old = OldState::dropped},
     .runs_on = RunsOn::primary},
    // It runs after all other stages, so that its reports contain the results of the minor frame.
    {.component = ComponentId::telemetry,
     .name = "telemetry",
     .page = "telemetry",
     .wakes = mask_of(event, command),
     .reads = mask_of(event, command, commanding, storage, capture, frame, overlap, strip, keyframe, camera,
                      calibration, calibration_check, pose, depth, mask, richness, product, downlink, transfer, uplink,
                      timing, node, component, fix),
     .period = 1,
     .budget_ns = 10 * ns_per_ms,
     .state = {.number = 2, .old = OldState::dropped},
     .runs_on = RunsOn::primary},
};
}  // namespace stage_rows

inline constexpr auto& schedule = stage_rows::rows;

inline constexpr std::size_t stage_count = sizeof(schedule) / sizeof(schedule[0]);
/// The largest number of a component.
inline constexpr std::size_t component_numbers = [] {
  ComponentId greatest = ComponentId::none;
  for (const Stage& stage : schedule) greatest = stage.component > greatest ? stage.component : greatest;
  return static_cast<std::size_t>(greatest);
}();

/// The row of a component's number; the null pointer if there is none.
[[nodiscard]] constexpr const Stage* find_stage(std::uint64_t number) {
  for (const Stage& stage : schedule) {
    if (static_cast<std::uint64_t>(stage.component) == number && number != 0) return &stage;
  }
  return nullptr;
}
[[nodiscard]] constexpr const char* component_name(std::uint64_t number) {
  const Stage* const stage = find_stage(number);
  return stage == nullptr ? "package" : stage->name;
}
static_assert(
    [] {
      for (const Stage& stage : schedule) {
        if (find_stage(static_cast<std::uint64_t>(stage.component)) != &stage) return false;
      }
      return true;
    }(),
    "two rows have the same number, or one has none");

/// Most processes that can share a flight: the primary, and one for each stage that may run elsewhere.
inline constexpr std::size_t most_nodes = [] {
  std::size_t nodes = 1;
  for (const Stage& stage : schedule) nodes += stage.runs_on == RunsOn::any ? 1 : 0;
  return nodes;
}();

[[nodiscard]] constexpr const Stage& stage_of(ComponentId component) {
  return *find_stage(static_cast<std::uint64_t>(component));
}
/// The index of a component's row.
[[nodiscard]] constexpr std::size_t place_of(ComponentId component) {
  return static_cast<std::size_t>(&stage_of(component) - schedule);
}

}  // namespace ilp
