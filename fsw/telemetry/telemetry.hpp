// Tells the ground how the package fares: housekeeping (service 3) and events (service 5).
#pragma once

#include <array>
#include <cstddef>
#include <type_traits>

#include "cfg/mission.hpp"
#include "fsw/commanding/telecommand_answer.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/link/packet_router.hpp"
#include "fsw/link/service_events.hpp"
#include "fsw/link/service_housekeeping.hpp"
#include "fsw/link/telemetry_writer.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/telemetry/telemetry_reports.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

struct DeliveryCounts;

/// Counters that are read where they stand; null pointers read as zeros.
struct TelemetrySources {
  const Health* health = nullptr;
  const DeliveryCounts* delivery = nullptr;
};

/// Reports of telemetry_reports.hpp, periodic and one-shot; events of the store as they come, those of the time out of
/// contact behind it. While reports wait for contact no new ones are made: of a periodic report the newest goes then.
/// What is enabled, intervals and disabled events survive a restart.
class TelemetryReporter final : public StageComponent<ComponentId::telemetry>, public TelecommandService {
 public:
  TelemetryReporter(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock,
                    const MissionParameters& mission, TelemetrySources sources = {});

  Status restore() override;
  StepResult step() override;

  /// Services 3 and 5. Of a list all is done or nothing. `report_unknown` (a = SID), `report_interval` (a = ms),
  /// `event_unknown` (a = event), each with b = item of the list.
  [[nodiscard]] bool serves(std::uint8_t service) const override;
  Status perform(const Telecommand& telecommand, Answer& answer) override;
  void settled(bool committed) override;

 private:
  static constexpr TimeNs default_interval_ns = 10 * ns_per_s;
  static constexpr std::size_t event_count = status_code_limit;
  /// By SID, and by code of the event; without padding.
  struct State {
    State() { interval_ns.fill(default_interval_ns); }
    std::array<TimeNs, report_id_limit> interval_ns;
    std::array<std::uint8_t, report_id_limit> enabled{};
    std::array<std::uint8_t, 256> disabled{};
  };
  static const CheckpointForm checkpoint;
  static_assert(report_count < report_id_limit && event_count <= 256);
  static_assert(std::has_unique_object_representations_v<State>);

  Status manage_housekeeping(const Telecommand& telecommand, Answer& answer);
  Status set_intervals(const Telecommand& telecommand, Answer& answer);
  Status manage_events(const Telecommand& telecommand, Answer& answer);
  Status report_disabled(const Telecommand& telecommand, Answer& answer);
  Status save(const State& state);

  Status tell_events();
  Status tell(const EventRecord& event);
  Status send_due();
  Status send(const ReportInfo& report);
  Status write_values(const ReportInfo& report, ByteWriter& out);
  Status package_status(PackageStatus& status);
  [[nodiscard]] LinkCounts link_counts() const;
  [[nodiscard]] ComponentHealth health(std::size_t component) const;

  Tables store_;
  PacketRouter& router_;
  TelemetryWriter& writer_;
  Clock& clock_;
  const MissionParameters& mission_;
  TelemetrySources sources_;
  Cursor cursor_;  ///< last event told
  bool cursor_unsaved_ = false;
  State state_;
  State after_;                                   ///< of the telecommand at work
  std::array<TimeNs, report_id_limit> due_ns_{};  ///< by SID
  alignas(std::max_align_t) std::array<std::uint8_t, limits::max_record_bytes> record_{};
  std::array<std::uint8_t, limits::max_report_bytes> report_{};
};

}  // namespace ilp
