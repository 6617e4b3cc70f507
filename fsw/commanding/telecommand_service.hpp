// The data of the Telecommander, and the interface to the services that carry out telecommands.
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
/// The kind of event that completes a telecommand. The values are stored in checkpoints. A telecommand of kind `noted`
/// is completed at once and never open.
enum class OpenKind : std::uint8_t { captures, begin_strip, end_strip, flush, delete_product, restart, report, noted };
/// A telecommand that has started and is not completed yet.
struct OpenRequest {
  std::int64_t id = 0;
  TimeNs deadline_ns = 0;                 ///< the request fails if it is not completed then
  TimeNs begin_ns = 0;                    ///< when acceptance and start are reported; 0: they were reported
  std::int64_t subject_id = 0;            ///< id of the command or product, or number of the component
  std::int64_t mark_id = 0;               ///< newest event that was examined for the completion
  TimeNs next_ns = 0;                     ///< time of the next image of a series that has to be commanded
  TimeNs interval_ns = 0;                 ///< interval of the series; 0: a single image
  std::int64_t fault_a = 0, fault_b = 0;  ///< values of `fault`
  std::uint32_t packet = 0;
  std::uint16_t source = 0;
  std::uint16_t fault = 0;        ///< StatusCode of the first capture that failed; 0: none
  std::uint16_t left = 0;         ///< captures that have to be commanded
  std::uint16_t outstanding = 0;  ///< captures that were commanded and have no result yet
  std::uint16_t settled = 0;      ///< captures with a result
  std::uint8_t ack_flags = 0;
  OpenKind kind = OpenKind::captures;
};
/// A pending capture of an open request.
struct WatchedCapture {
  std::int64_t capture_id = 0;
  std::int64_t request_id = 0;
};
struct CommandingState {
  CommandingRecord counts;
  std::int64_t last_request_id = 0;
  std::int64_t last_capture_id = 0;  ///< captures up to this one have been examined
  std::int64_t last_scheduled_id = 0;
  FixedVector<OpenRequest, limits::max_open_requests> open;
  FixedVector<WatchedCapture, limits::max_open_requests> watched;
};
/// An entry of the time-based schedule. Its packet is in the store.
struct ScheduleEntry {
  std::int64_t id = 0;  ///< id of its record
  TimeNs release_ns = 0;
  ScheduledId name;
  bool ahead = false;       ///< it commands a capture and is released before its time
  std::uint32_t bytes = 0;  ///< size of the packet
};
struct CommandingWork {
  MissionParameters wanted;  ///< includes parameters that take effect only at the next start
  FixedVector<ScheduleEntry, limits::max_scheduled> entries;  ///< in order of time
};
/// The changes in memory by one telecommand, applied after the commit.
struct TelecommandChange {
  CommandingState after;
  MissionParameters wanted;
  bool set = false;  ///< parameters have been set
  Configuration::Way way = Configuration::Way::parameters;
  bool rescheduled = false;  ///< the schedule becomes `entries_after` of the workspace
  TimeNs nominal_ns = 0;     ///< intended time of the telecommand: its release time, or the time of its arrival
};
/// A change of an open request, reported after it is committed.
struct RequestUpdate {
  OpenRequest request;
  Status status;  ///< result of a finished request
  enum class Kind : std::uint8_t { begun, progress, finished } kind = Kind::finished;
};
using RequestUpdateList = FixedVector<RequestUpdate, 3 * limits::max_open_requests>;
struct CommandingWorkspace {
  std::size_t came_before = 0;  ///< waiting telecommands that arrived before the latest parameters took effect
  decltype(CommandingWork::entries) entries_after;  ///< the schedule after the present telecommand
  TelecommandChange change;
  RequestUpdateList updates;
  std::uint32_t frames = 0;
  std::uint32_t reported_lost = 0;
  StatusCode pump_fault = StatusCode::ok;  ///< the latest fault of the link, which is reported once
  bool counts_changed = false;
  bool set_parameters = false;  ///< this step has changed the mission parameters
  std::array<std::uint8_t, limits::max_scheduled_bytes> scheduled_packet{};
  std::array<std::uint8_t, limits::max_report_bytes> report{};
  std::size_t packet_bytes = 0;  ///< size of the telecommand in `packet` that waits for the store's lock; 0: none
  LockTimes lock;                ///< the store's lock, as the latest attempts found it
  std::array<std::uint8_t, limits::max_packet_bytes> packet{};
};

/// The telecommand that is carried out, with everything that a service needs.
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
/// Each carries out the telecommands of one service. Its source is service_N.cpp, with the service's number N.
Service serve_housekeeping, serve_events, serve_functions, serve_schedule, serve_tests, serve_parameters;
/// Returns the null pointer if there is no service of this number.
[[nodiscard]] Service* find_service(std::uint8_t number);

// service_20.cpp
Status set_parameter(const char* section, const char* key, double value, ServiceCall& call);
/// Checks the parameters `wanted`, and writes setting records for those that differ from the present ones.
Status set_parameters(const MissionParameters& wanted, ServiceCall& call,
                      Configuration::Way way = Configuration::Way::parameters);

// service_11.cpp
/// Reads the entries of the schedule from the store.
Status read_schedule(const CommandingWiring& wiring, CommandingWork& work);

// open_requests.cpp
/// Writes a command with a new id, in an open transaction.
Status write_command(const CommandingWiring& wiring, CommandRecord& command);
/// Adds an open request: the telecommand is answered when the request is completed. Returns `requests_full` if there
/// are too many.
Status keep_open(OpenRequest request, ServiceCall& call);
/// As keep_open(), for a request that is completed when telemetry has carried out the command.
Status wait_for_telemetry(std::int64_t command_id, ServiceCall& call);
/// Finds new captures of open requests. Returns whether there are any.
Result<bool> learn_captures(const CommandingWiring& wiring, CommandingState& after);
/// Follows the open requests in an open transaction. Returns whether anything has changed.
Result<bool> follow_requests(const CommandingWiring& wiring, CommandingState& after, RequestUpdateList& updates);
void report_update(const RequestUpdate& updates, TelemetryWriter& writer);

/// The largest mission time and duration in a telecommand, so that sums cannot overflow.
inline constexpr TimeNs farthest_ns = TimeNs{3'000'000'000} * ns_per_s;

}  // namespace ilp
