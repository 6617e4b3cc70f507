// What the Telecommander keeps, and what the services that carry out telecommands are given of it.
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/base/lock_times.hpp"
#include "fsw/commanding/configuration.hpp"
#include "fsw/commanding/telecommand_answer.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/telemetry_writer.hpp"
#include "fsw/shared/find.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

struct CommandingWiring {
  StageStore<ComponentId::telecommander> store;
  PacketRouter& router;
  TelemetryWriter& writer;
  Clock& clock;
  MissionParameters& mission;
  Configuration* configuration;
};
/// What completes a telecommand. The values stand in checkpoints; `noted` is completed at once and never open.
enum class OpenKind : std::uint8_t { captures, begin_strip, end_strip, flush, delete_product, restart, report, noted };
/// A telecommand that has started and whose completion is still to come.
struct OpenRequest {
  std::int64_t id = 0;
  TimeNs deadline_ns = 0;
  TimeNs begin_ns = 0;          ///< acceptance and start are reported then; 0: they have been
  std::int64_t subject_id = 0;  ///< command, product or component
  std::int64_t mark_id = 0;     ///< newest event when it began
  TimeNs next_ns = 0;           ///< of a series: the next image to command
  TimeNs interval_ns = 0;
  std::int64_t fault_a = 0, fault_b = 0;  ///< of the first capture that failed
  std::uint32_t packet = 0;
  std::uint16_t source = 0;
  std::uint16_t fault = 0;
  std::uint16_t left = 0;         ///< captures still to be commanded
  std::uint16_t outstanding = 0;  ///< captures that are commanded and not answered
  std::uint16_t settled = 0;
  std::uint8_t ack_flags = 0;
  OpenKind kind = OpenKind::captures;
};
struct WatchedCapture {
  std::int64_t capture_id = 0;
  std::int64_t request_id = 0;
};
struct CommandingState {
  CommandingRecord counts;
  std::int64_t last_request_id = 0;
  std::int64_t last_capture_id = 0;  ///< captures up to it have been examined
  std::int64_t last_scheduled_id = 0;
  FixedVector<OpenRequest, limits::max_open_requests> open;
  FixedVector<WatchedCapture, limits::max_open_requests> watched;
};
/// What the schedule holds, in order of time; the packets are in the store.
struct ScheduleEntry {
  std::int64_t id = 0;
  TimeNs release_ns = 0;
  ScheduledId name;
  bool ahead = false;
  std::uint32_t bytes = 0;
};
struct CommandingWork {
  MissionParameters wanted;  ///< with what takes effect at the next start only
  FixedVector<ScheduleEntry, limits::max_scheduled> entries;
};
/// What one telecommand changes, in memory only.
struct TelecommandChange {
  CommandingState after;
  MissionParameters wanted;
  bool set = false;  ///< parameters have been set
  Configuration::Way way = Configuration::Way::parameters;
  bool rescheduled = false;  ///< `entries_after` of the workspace counts
  TimeNs nominal_ns = 0;     ///< when the telecommand is meant to be carried out
};
/// A change of an open request, reported after it is committed.
struct RequestUpdate {
  OpenRequest request;
  Status status;  ///< of a request that is finished
  enum class Kind : std::uint8_t { begun, progress, finished } kind = Kind::finished;
};
using RequestUpdateList = FixedVector<RequestUpdate, 3 * limits::max_open_requests>;
struct CommandingWorkspace {
  std::size_t came_before = 0;  ///< telecommands that had come before the latest parameters took effect
  decltype(CommandingWork::entries) entries_after;  ///< of the telecommand at work
  TelecommandChange change;
  RequestUpdateList updates;
  std::uint32_t frames = 0;
  std::uint32_t reported_lost = 0;
  StatusCode pump_fault = StatusCode::ok;  ///< reported once
  bool counts_changed = false;
  bool set_parameters = false;  ///< in this step
  std::array<std::uint8_t, limits::max_scheduled_bytes> scheduled_packet{};
  std::array<std::uint8_t, limits::max_report_bytes> report{};
  std::size_t packet_bytes = 0;  ///< of a telecommand that waits for the lock of the store
  LockTimes lock;                ///< by the latest try
  std::array<std::uint8_t, limits::max_packet_bytes> packet{};
};

/// A telecommand at work.
struct ServiceCall {
  const CommandingWiring& wiring;
  const CommandingWork& work;
  CommandingWorkspace& workspace;
  const Telecommand& telecommand;
  Answer& answer;
  TelecommandChange& change;

  [[nodiscard]] const Tailoring& tailoring() const { return wiring.writer.settings().tailoring; }
  [[nodiscard]] TimeNs now() const { return wiring.clock.now(); }
  [[nodiscard]] Status subtype_unknown() const {
    return {StatusCode::subtype_unknown, telecommand.service, telecommand.subtype};
  }
};
using Service = Status(ServiceCall& call);
/// Each is in the source of the service's number.
Service serve_housekeeping, serve_events, serve_functions, serve_schedule, serve_tests, serve_parameters;
/// The null pointer where there is none of this number.
[[nodiscard]] Service* find_service(std::uint8_t number);

// service_20.cpp
Status set_parameter(const char* section, const char* key, double value, ServiceCall& call);
/// Records of what differs from what was wanted so far; in range and without contradiction.
Status set_parameters(const MissionParameters& wanted, ServiceCall& call,
                      Configuration::Way way = Configuration::Way::parameters);

// service_11.cpp
Status read_schedule(const CommandingWiring& wiring, CommandingWork& work);

// open_requests.cpp
/// In an open transaction. It numbers the command.
Status write_command(const CommandingWiring& wiring, CommandRecord& command);
/// The telecommand is answered when the request is completed.
Status keep_open(OpenRequest request, ServiceCall& call);
/// Completed when telemetry has obeyed the command.
Status wait_for_telemetry(std::int64_t command_id, ServiceCall& call);
/// Finds new captures of open requests. Whether there are any.
Result<bool> learn_captures(const CommandingWiring& wiring, CommandingState& after);
/// Follows the open requests in an open transaction. Whether anything has changed.
Result<bool> follow_requests(const CommandingWiring& wiring, CommandingState& after, RequestUpdateList& updates);
void report_update(const RequestUpdate& updates, TelemetryWriter& writer);

/// Times are at most this far away, so that sums cannot overflow.
inline constexpr TimeNs farthest_ns = TimeNs{3'000'000'000} * ns_per_s;

}  // namespace ilp
