// Sends what is worth most and hears what has arrived: Product -> Acknowledged (file formats: docs/outbox.md).
#pragma once

#include <array>

#include "cfg/link_shares.hpp"
#include "cfg/mission.hpp"
#include "fsw/downlink/outgoing_file.hpp"
#include "fsw/downlink/pass_planner.hpp"
#include "fsw/downlink/set_aside_list.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/link/pass_schedule.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

inline constexpr std::int64_t events_per_file = 64;

/// One file a step, within the link's mean rate, during passes only. In this order: the first layers of products that
/// have waited too long (within a quarter of a pass, oldest first), what has not had its share of the link
/// (cfg/link_shares.hpp), the records of keyframes, products as plan_pass puts them, sparse points, events when there
/// are enough of them or time has passed. With downlink_order = 1 whole products in the order of their keyframes
/// instead. A product goes as its first layers, later refined by the rest; it is done with only when the ground has
/// confirmed size and CRC of every file of it. Without contact everything waits. Records, points and events whose
/// confirmation is overdue go again; products do at the word of the storage manager.
///
/// Shares: every file that goes gives each class its share of the file's bytes as a credit, and takes the file's bytes
/// from that of its own class; a class whose credit holds its next file goes first, the largest credit before others.
/// So in any stretch of a link that never empties a class that has files gets its share of all bytes but for one file.
///
/// What fails for one file is set aside and holds up no other: it is tried again after growing pauses. Where the store
/// answers otherwise, 12 such faults, or 3 that do not pass by themselves, end it: a product is given up as damaged,
/// records go without what cannot be read, points and single events are left out, each with an event. What the link
/// does not take is never given up. Confirmations are committed by themselves, before anything is sent.
///
/// Nothing waits for ever: of the products that were there `overdue_passes` passes ago and of which nothing has gone,
/// every pass sends the oldest, and as many more as fit into a quarter of it. So the first layer of a product goes at
/// the latest in the pass overdue_passes + 1 + n after it was made, where n counts the older products and records that
/// were waiting then (as long as no file is larger than a pass).
class Downlink final : public StageComponent<ComponentId::downlink> {
 public:
  static const CheckpointForm checkpoint;

  Downlink(Tables store, Link& link, Clock& clock, const MissionParameters& mission);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory(cursor_, state_).of(*this).at_work(event_, hear_alone_);
  }

  /// Everything that there is has been sent, and confirmed.
  [[nodiscard]] bool drained() const { return drained_; }

 private:
  static constexpr std::size_t max_late_files = 32;

  /// A file that has to go although the cursors have passed it: set aside, or not confirmed in time.
  struct Late {
    FileClass kind = FileClass::records;
    std::int64_t id = 0;  ///< keyframe, structure, or the first event of the file
    bool operator==(const Late&) const = default;
  };
  using LateList = FixedVector<Late, max_late_files>;

  struct State {
    std::int64_t credit_bytes = 0;  ///< what the link can take now; negative after a large file
    TimeNs credited_ns = 0;
    std::int64_t last_downlink_id = 0;
    std::int64_t records_through = 0;  ///< keyframes up to it have been sent as records, but for those that are late
    std::int64_t points_through = 0;   ///< and their sparse points
    std::int64_t events_through = 0;
    std::int64_t event_files = 0;
    std::int64_t housekeeping_steps = 0;  ///< fingerprint of the housekeeping last sent
    TimeNs events_sent_ns = 0;
    std::int64_t acknowledged_through = 0;  ///< downlinks up to it are all acknowledged
    std::int64_t pass = -1;                 ///< number of the present pass
    std::int64_t pass_bytes = 0;            ///< sent in it
    std::int64_t overdue_bytes = 0;         ///< of them first layers that were overdue
    /// Newest product when this pass began, when the one before it began, ...
    std::array<std::int64_t, limits::max_overdue_passes + 1> product_at_pass{};
    std::array<std::int64_t, file_classes> owed_bytes{};  ///< what each class has not had of its share
    std::int64_t planned_bytes = 0;        ///< of the file of products that goes next, as far as it is known
    std::int64_t check_products_from = 0;  ///< 0: no product has to be looked at
    LateList late;
  };
  /// What a file is about.
  struct Subject {
    FileClass kind = FileClass::count;  ///< `count`: nothing yet
    std::int64_t id = 0;
  };

  void credit(State& after, const Contact& contact);
  Status begin_pass(State& after, const Contact& contact, bool& begun);
  /// What is on record behind the checkpoint, where an older one was loaded.
  Status catch_up();

  // Confirmations
  Status hear_all();
  Status hear(State& after, bool& heard);
  Status hear_one(DownlinkRecord record, State& after, bool& settled, bool& heard);
  Status hear_layers(const DownlinkRecord& record, ProductRecord product);
  Status drop_if_lost(const DownlinkRecord& record, State& after, bool& settled, bool& heard);
  /// A record of a file was damaged: of what was sent and is not confirmed everything goes again.
  Status check_products(State& after, bool& changed);

  // What goes next; `most`: of bytes
  Status send_next(State& after, bool& sent);
  Status send_owed(State& after, bool& sent);
  Status send_class(FileClass kind, std::int64_t most, State& after, bool& sent);
  Status send_overdue(State& after, bool& sent);
  Status send_planned(std::int64_t most, State& after, bool& sent);
  Status send_in_order(std::int64_t most, State& after, bool& sent);
  Status send_next_records(std::int64_t most, State& after, bool& sent);
  Status send_next_points(std::int64_t most, State& after, bool& sent);
  Status send_events_if_due(std::int64_t most, State& after, bool& sent);
  /// The first of the late files of a class that is not set aside; 0: none.
  [[nodiscard]] std::int64_t late_one(const State& after, FileClass kind) const;
  /// Whether a file of so many bytes may go now; if not, its class has something that waits.
  bool may_go(const State& after, std::int64_t bytes, std::int64_t most);

  // The files (downlink_files.cpp)
  Status send_records(std::int64_t keyframe_id, State& after, bool& sent);
  Status write_mask(std::int64_t keyframe_id);
  Status write_products_of(std::int64_t keyframe_id);
  Status send_points(std::int64_t id, std::int64_t most, State& after, bool& sent);
  Status send_layers(const ProductRecord& product, int last_layer, State& after, bool& sent);
  Status write_refinement(const ProductRecord& product, std::span<const std::uint8_t> longer, int last_layer);
  /// Behind `through`; with `late` they are those of a file that was lost.
  Status send_events(std::int64_t through, bool late, std::int64_t housekeeping_steps, State& after, bool& sent);
  void housekeeping_fingerprint(std::int64_t& steps);
  Status open(const char* name);
  Status close_file(DownlinkRecord sent, State& after);
  void drop_late(const Late& late, State& after);

  Status find_requests();
  /// The first product behind `product` that waits and whose records have gone.
  Status next_waiting(const State& after, ProductRecord& product, bool& found);
  [[nodiscard]] bool waits(const State& after, const ProductRecord& product) const;
  Status gather(const State& after);
  [[nodiscard]] bool requested(std::int64_t keyframe_id) const;
  /// Whether a file of so many bytes may go before the pass ends.
  [[nodiscard]] bool fits(const State& after, std::int64_t bytes) const;

  /// Sends the next file, if there is contact; its loss and its return are events.
  Status send_in_contact(State& after, bool& sent);
  StepResult send_one();
  /// A file could not be made or handed over: an event, or the fault where it concerns all of them.
  Status set_aside(const Status& fault, bool& others);
  [[nodiscard]] bool given_up(FileClass kind, std::int64_t id) const;
  [[nodiscard]] bool rests(FileClass kind, std::int64_t id) const;

  Tables store_;
  Link& link_;
  Clock& clock_;
  const MissionParameters& mission_;
  Cursor cursor_;
  State state_;
  Status event_;
  bool drained_ = false;
  bool contact_lost_ = false;
  TimeNs contact_lost_ns_ = 0;
  std::int64_t asked_through_ = 0;  ///< downlinks up to it have been asked for in this round
  TimeNs newest_sent_ns_ = 0;
  std::int64_t room_bytes_ = 0;  ///< that the link can still take in this pass
  Subject subject_;
  bool store_failed_ = false;     ///< what was to be written was not taken
  bool something_waits_ = false;  ///< the class that was asked last has a file
  bool changed_ = false;          ///< the state has changed without a file
  int hear_alone_ = 0;
  SetAsideList<32> set_aside_;
  OutgoingFile file_;
  FixedVector<std::int64_t, limits::max_refine_requests> requests_;  ///< keyframes
  CandidateList candidates_;
  PassPlan plan_;
  PlanWorkspace workspace_;
  std::array<std::uint8_t, limits::max_product_bytes> product_{};
};

}  // namespace ilp
