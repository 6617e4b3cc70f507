// Takes telecommands from the link and from the schedule, carries them out, and reports what becomes of each.
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/base/fixed_vector.hpp"
#include "fsw/commanding/configuration.hpp"
#include "fsw/commanding/function_table.hpp"
#include "fsw/commanding/telecommand_answer.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/telemetry_writer.hpp"
#include "fsw/shared/find.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

/// Services 1, 3, 5, 8, 11, 17 and 20 of ECSS-E-ST-70-41C (docs/commanding.md). Every telecommand whose primary header
/// can be read is answered. What a telecommand changes is committed before its success is reported: it acts on the
/// other components through records only, of which `command` carries most. Requests whose completion takes time, and
/// the schedule, survive a restart. While another process keeps the lock of the store, telecommands that change nothing
/// are carried out; any other one waits for two seconds from the beginning of the lock, and then fails with
/// `store_locked`.
///
/// telecommander.cpp is the dispatcher; each service_N.cpp carries out the telecommands of one service, and
/// open_requests.cpp follows those whose completion takes time.
class Telecommander final : public StageComponent<ComponentId::telecommander> {
 public:
  static const CheckpointForm checkpoint;

  /// Parameters set by telecommand take effect in `mission`. The configuration puts them on trial; without it they are
  /// settings in the store.
  Telecommander(Tables store, PacketRouter& router, TelemetryWriter& writer, Clock& clock, MissionParameters& mission,
                Configuration* configuration = nullptr);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

  [[nodiscard]] const CommandingRecord& counts() const { return state_.counts; }

 private:
  struct Wiring {
    Tables store;
    PacketRouter& router;
    TelemetryWriter& writer;
    Clock& clock;
    MissionParameters& mission;
    Configuration* configuration;
  };
  /// What completes a telecommand. The values stand in checkpoints; `noted` is completed at once and never open.
  enum class OpenKind : std::uint8_t {
    captures,
    begin_strip,
    end_strip,
    flush,
    delete_product,
    restart,
    report,
    noted
  };
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
    std::uint16_t outstanding = 0;  ///< captures that are commanded and not settled
    std::uint16_t settled = 0;
    std::uint8_t ack_flags = 0;
    OpenKind kind = OpenKind::captures;
  };
  struct Watched {
    std::int64_t capture_id = 0;
    std::int64_t request_id = 0;
  };
  struct State {
    CommandingRecord counts;
    std::int64_t last_request_id = 0;
    std::int64_t last_capture_id = 0;  ///< captures up to it have been examined
    std::int64_t last_scheduled_id = 0;
    FixedVector<OpenRequest, limits::max_open_requests> open;
    FixedVector<Watched, limits::max_open_requests> watched;
  };
  /// What the schedule holds, in order of time; the packets are in the store.
  struct Entry {
    std::int64_t id = 0;
    TimeNs release_ns = 0;
    ScheduledId name;
    bool ahead = false;
    std::uint32_t bytes = 0;
  };
  using Entries = FixedVector<Entry, limits::max_scheduled>;
  struct Work {
    MissionParameters wanted;  ///< with what takes effect at the next start only
    Entries entries;
  };
  /// What one telecommand changes, in memory only.
  struct Change {
    State after;
    MissionParameters wanted;
    bool set = false;  ///< parameters have been set
    Configuration::Way way = Configuration::Way::parameters;
    bool rescheduled = false;  ///< `entries` have changed
    TimeNs nominal_ns = 0;     ///< when the telecommand is meant to be carried out
  };
  /// A change of an open request, reported after it is committed.
  struct News {
    OpenRequest request;
    Status status;  ///< of a request that is finished
    enum class Kind : std::uint8_t { begun, progress, finished } kind = Kind::finished;
  };
  using NewsList = FixedVector<News, 3 * limits::max_open_requests>;
  struct Workspace {
    std::size_t came_before = 0;  ///< telecommands that had come before the latest parameters took effect
    Entries entries_after;        ///< of the telecommand at work
    Change change;
    NewsList news;
    std::uint32_t frames = 0;
    std::uint32_t reported_lost = 0;
    StatusCode pump_fault = StatusCode::ok;  ///< reported once
    bool counts_changed = false;
    bool set_parameters = false;  ///< in this step
    std::array<std::uint8_t, limits::max_scheduled_bytes> scheduled_packet{};
    std::array<std::uint8_t, limits::max_report_bytes> report{};
    std::size_t packet_bytes = 0;  ///< of a telecommand that waits for the lock of the store
    TimeNs locked_since_ns = -1;   ///< the lock was first found taken; -1: it was free at the latest try
    std::array<std::uint8_t, limits::max_packet_bytes> packet{};
  };

  /// A function of service 8 at work.
  struct Call {
    TimeNs time = 0;
    ByteReader arguments;
    Answer& answer;
    Change& change;
    OpenRequest request = {};  ///< filled by functions that are not completed at once
  };
  struct ServiceRow {
    std::uint8_t service;
    Status (Telecommander::*carry_out)(const Telecommand& telecommand, Answer& answer, Change& change);
  };
  static const ServiceRow services[];
  struct FunctionRow {
    Function function;
    Status (Telecommander::*effect)(Call& call);
    OpenKind completion;
  };
  static const FunctionRow functions[];

  // telecommander.cpp
  void receive();
  /// Whether the telecommand waits for the lock of the store, and all later ones with it.
  bool waits_for_lock(std::span<const std::uint8_t> packet);
  Status try_store();
  void release();
  void release_one(const Entry& entry, TimeNs now);
  void carry_out(std::span<const std::uint8_t> packet, TimeNs nominal_ns, const Entry* entry);
  Status perform(const Telecommand& telecommand, const Entry* entry, Answer& answer, Change& change);
  Status serve(const Telecommand& telecommand, Answer& answer, Change& change);
  void settle(const Change& change, bool committed);
  void take_effect(bool accepted, const Status& status, bool from_the_link);
  [[nodiscard]] static const ServiceRow* find_service(std::uint8_t service);
  [[nodiscard]] static bool changes_nothing(const Telecommand& telecommand);
  Status write_counts();
  Status news_of_configuration();
  void drop_entry(std::int64_t id);
  /// In memory only.
  void forget_entry(std::int64_t id);

  // service_3.cpp: housekeeping
  Status service_3(const Telecommand& telecommand, Answer& answer, Change& change);
  Status set_intervals(const Telecommand& telecommand, Answer& answer, Change& change);
  // service_5.cpp: events
  Status service_5(const Telecommand& telecommand, Answer& answer, Change& change);
  /// Completed when telemetry has obeyed the command.
  Status wait_for_telemetry(std::int64_t command_id, Answer& answer, Change& change);

  // service_8.cpp: functions
  Status service_8(const Telecommand& telecommand, Answer& answer, Change& change);
#define FUNCTION(number, effect, name, arguments, completion, meaning) Status effect(Call& call);
#include "fsw/commanding/functions.inc"
  Status command_capture(CommandKind kind, TimeNs at, Call& call);
  Status command_end_of_strip(Call& call);
  Status write_command(CommandRecord command, std::int64_t& id);
  Status open(OpenRequest request, Answer& answer, Change& change);

  // service_20.cpp: parameters
  Status service_20(const Telecommand& telecommand, Answer& answer, Change& change);
  Status report_parameters(const Telecommand& telecommand, Answer& answer);
  Status set_parameters(const Telecommand& telecommand, Answer& answer, Change& change);
  Status set_one(const char* section, const char* key, double value, Change& change);
  /// Records of what differs from what was wanted so far; in range and without contradiction.
  Status set_all(const MissionParameters& wanted, Change& change);
  /// Whether the parameters do not contradict each other, and do not lock the ground out.
  [[nodiscard]] Status check_together(const MissionParameters& wanted) const;

  // service_17.cpp: tests
  Status service_17(const Telecommand& telecommand, Answer& answer, Change& change);

  // service_11.cpp: the schedule
  Status service_11(const Telecommand& telecommand, Answer& answer, Change& change);
  Status insert(const Telecommand& telecommand, Answer& answer, Change& change);
  Status check_insert(const ScheduleItem& item, std::uint32_t index, TimeNs now, ScheduledRecord& scheduled) const;
  Status remove(const Telecommand& telecommand, Answer& answer, Change& change);
  Status shift(const Telecommand& telecommand, bool all, Answer& answer, Change& change);
  Status report_schedule(const Telecommand& telecommand, bool detail, Answer& answer);
  static Entry entry_of(const ScheduledRecord& scheduled);
  Status read_schedule();
  [[nodiscard]] Status check_known(const ScheduledIdList& ids) const;

  // open_requests.cpp
  Status follow_requests();
  Status learn_captures(State& after, bool& changed);
  Status follow_captures(State& after, NewsList& news, bool& changed);
  Status command_series(State& after, TimeNs now, bool& changed);
  Status follow_open(State& after, TimeNs now, NewsList& news, bool& changed);
  Status follow_one(OpenRequest& request, TimeNs now, NewsList& news, bool& over, bool& changed);
  Status is_done(OpenRequest& request, bool& done);
  Status is_flushed(bool& done);
  Status is_restarted(OpenRequest& request, bool& done);
  void report_news(const News& news);

  /// Times are at most this far away, so that sums cannot overflow.
  static constexpr TimeNs farthest_ns = TimeNs{3'000'000'000} * ns_per_s;

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
