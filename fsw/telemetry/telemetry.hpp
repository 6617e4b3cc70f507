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

/// Counters of other objects. For a null pointer zeros are reported.
struct TelemetrySources {
  const Health* health = nullptr;
  const DeliveryCounts* delivery = nullptr;
};

/// Sends the reports of fsw/packets/report_table.hpp, periodically or once, and the events of the store in their order.
/// Events that occur out of contact are sent at the next contact. No reports are made while earlier ones wait for
/// contact; after that the present values of each periodic report are sent. The ground's requests are records of
/// `command`. Enabled reports, intervals and disabled events survive a restart.
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
  /// `interval_ns` and `enabled` are indexed by SID, `disabled` by the code of the event.
  struct State {
    std::array<TimeNs, report_id_limit> interval_ns = default_intervals();
    std::array<std::uint8_t, report_id_limit> enabled{};
    std::array<std::uint8_t, 256> disabled{};
  };
  struct Work {
    std::array<TimeNs, report_id_limit> due_ns{};  ///< when the next report is due, indexed by SID
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
  Cursor cursor_;  ///< last event that was reported; last command that was carried out
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
