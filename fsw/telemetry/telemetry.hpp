// Reports the package's state to the ground: housekeeping (service 3) and events (service 5).
#pragma once

#include <array>
#include <cstddef>

#include "cfg/mission.hpp"
#include "fsw/base/result.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_events.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/telemetry_writer.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

struct DeliveryCounts;

/// Counters of other objects; null pointers read as zeros.
struct TelemetrySources {
  const Health* health = nullptr;
  const DeliveryCounts* delivery = nullptr;
};

/// Sends the reports of fsw/packets/report_table.hpp, periodic and one-shot, and the events of the store in their
/// order; events from the time out of contact follow at the next contact. While reports wait for contact no further
/// ones are made; the newest of each periodic report is then sent. The ground's requests are records of `command`.
/// Enabled reports, intervals and disabled events survive a restart.
class TelemetryReporter final : public StageComponent<ComponentId::telemetry> {
 public:
  TelemetryReporter(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock,
                    const MissionParameters& mission, TelemetrySources sources = {});

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

 private:
  static constexpr TimeNs default_interval_ns = 10 * ns_per_s;
  static constexpr std::size_t event_count = status_code_limit;
  static constexpr std::array<TimeNs, report_id_limit> default_intervals() {
    std::array<TimeNs, report_id_limit> intervals{};
    intervals.fill(default_interval_ns);
    return intervals;
  }
  struct Wiring {
    Tables store;
    PacketRouter& router;
    TelemetryWriter& writer;
    Clock& clock;
    const MissionParameters& mission;
    TelemetrySources sources;
  };
  /// Indexed by SID, and by code of the event.
  struct State {
    std::array<TimeNs, report_id_limit> interval_ns = default_intervals();
    std::array<std::uint8_t, report_id_limit> enabled{};
    std::array<std::uint8_t, 256> disabled{};
  };
  struct Work {
    std::array<TimeNs, report_id_limit> due_ns{};  ///< by SID
    bool cursor_unsaved = false;
  };
  struct Workspace {
    alignas(8) std::array<std::uint8_t, limits::max_record_bytes> record{};
    std::array<std::uint8_t, limits::max_report_bytes> report{};
  };
  static const CheckpointForm checkpoint;
  static_assert(report_count < report_id_limit && event_count <= 256);

  // telemetry_commands.cpp
  Status obey_commands();
  Status obey(const CommandRecord& command);
  void switch_events(std::int64_t event, bool disable);
  Status report_disabled(std::uint16_t destination);

  // telemetry.cpp
  Status report_events();
  Status report_event(const EventRecord& event);
  Status save_cursor();
  Status send_due();
  Status send(const ReportInfo& report);
  Status write_values(const ReportInfo& report, ByteWriter& out);
  Status package_status(PackageStatus& status);
  [[nodiscard]] LinkCounts link_counts() const;
  Result<ComponentHealth> health(ComponentId component);
  Result<NodeHealth> next_node(NodeRecord& node);

  Wiring wiring_;
  Cursor cursor_;  ///< last event reported, last command obeyed
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
