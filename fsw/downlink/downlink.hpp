// Sends the most valuable products and receives the confirmations: Product -> Acknowledged (file formats:
// docs/outbox.md).
#pragma once

#include <array>

#include "cfg/link_shares.hpp"
#include "cfg/mission.hpp"
#include "fsw/downlink/downlink_buffers.hpp"
#include "fsw/downlink/outgoing_file.hpp"
#include "fsw/downlink/pass_planner.hpp"
#include "fsw/downlink/set_aside_list.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/shared/find_next.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

inline constexpr std::int64_t events_per_file = 64;

/// Sends one file per step, within the link's mean rate, during passes only, and only when the link has less than a
/// second of that rate left to send: what is chosen before that could not be overtaken any more. The order is: the
/// first layers of products that have waited too long (within a quarter of a pass, oldest first), classes that have not
/// had their share of the link (cfg/link_shares.hpp), the records of keyframes, products as plan_pass orders them,
/// sparse points, and events when there are enough of them or time has passed. With downlink_order = 1 whole products
/// go in the order of their keyframes instead. A product is sent as its first layers, which the rest refines later. It
/// is finished only when the ground has confirmed size and CRC of each of its files. Without contact everything waits.
/// Records, points and events whose confirmation is overdue are sent again; the storage manager decides when products
/// are.
///
/// Shares: every file sent gives each class its share of the file's bytes as a credit, and takes the file's bytes from
/// the credit of its own class. A class whose credit covers its next file goes first, the largest credit before others.
/// On a permanently busy link, a class that has files thus gets its share of all bytes, to within one file.
///
/// A file that fails is set aside and delays no other file; it is tried again after growing pauses. If the store still
/// answers, the file is abandoned after 12 such faults, or after 3 permanent ones: a product is marked as damaged,
/// records are sent without the unreadable ones, points and single events are left out, each with an event. Files that
/// the link refuses are never abandoned. Confirmations are committed separately, before anything is sent.
///
/// No product waits for ever. Among the products that existed `overdue_passes` passes ago and of which nothing has been
/// sent, every pass sends the oldest, and as many more as fit into a quarter of it. The first layer of a product is
/// therefore sent at the latest in pass overdue_passes + 1 + n after it was made, where n counts the older products and
/// records that were waiting then (provided that no file is larger than a pass).
class Downlink final : public StageComponent<ComponentId::downlink> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = StepScratch<DownlinkBuffers>;

  Downlink(Tables store, Link& link, Clock& clock, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_, workspace_);
  }

  /// Everything has been sent and confirmed.
  [[nodiscard]] bool drained() const { return work_.drained; }

 private:
  static constexpr std::size_t max_late_files = 32;
  /// More bytes than any link carries, and few enough that sums of them do not overflow.
  static constexpr std::int64_t no_limit_bytes = std::int64_t{1} << 50U;

  /// A file that must be sent although the cursors have passed it: it was set aside, or not confirmed in time.
  struct Late {
    FileClass kind = FileClass::records;
    std::int64_t id = 0;  ///< keyframe, structure, or the first event of the file
    bool operator==(const Late&) const = default;
  };
  using LateList = FixedVector<Late, max_late_files>;

  struct Wiring {
    Tables store;
    Link& link;
    Clock& clock;
    const MissionParameters& mission;
    Scratch scratch;
  };
  struct State {
    std::int64_t credit_bytes = 0;  ///< bytes that the link can take now; negative after a large file
    TimeNs credited_ns = 0;
    std::int64_t last_downlink_id = 0;
    std::int64_t records_through = 0;  ///< records of keyframes up to it have been sent, except late ones
    std::int64_t points_through = 0;   ///< sparse points of keyframes up to it have been sent
    std::int64_t events_through = 0;
    std::int64_t event_files = 0;
    std::int64_t housekeeping_steps = 0;  ///< fingerprint of the housekeeping last sent
    TimeNs events_sent_ns = 0;
    std::int64_t acknowledged_through = 0;  ///< downlinks up to it are all acknowledged
    std::int64_t pass = -1;                 ///< number of the present pass
    std::int64_t pass_bytes = 0;            ///< sent in it
    std::int64_t overdue_bytes = 0;         ///< overdue first layers among them
    /// Newest product when this pass began, when the previous pass began, ...
    std::array<std::int64_t, limits::max_overdue_passes + 1> product_at_pass{};
    std::array<std::int64_t, file_classes> owed_bytes{};  ///< bytes missing from the share of each class
    std::int64_t planned_bytes = 0;                       ///< size of the next file of products, as far as it is known
    std::int64_t check_products_from = 0;                 ///< 0: no product needs a check
    LateList late;
  };
  /// The subject of a file.
  struct Subject {
    FileClass kind = FileClass::count;  ///< `count`: nothing yet
    std::int64_t id = 0;
  };
  struct Work {
    Status event;
    bool drained = false;
    bool contact_lost = false;
    TimeNs contact_lost_ns = 0;
    std::int64_t asked_through = 0;  ///< downlinks up to it have been queried in this round
    TimeNs newest_sent_ns = 0;
    std::int64_t room_bytes = 0;  ///< bytes that the link can still take in this pass
    Subject subject;
    bool store_failed = false;     ///< the store refused a write
    bool something_waits = false;  ///< the class asked last has a file
    bool changed = false;          ///< the state has changed without a file
    int hear_alone = 0;
    SetAsideList<32> set_aside;
  };
  struct Workspace {
    Workspace(Tables store, Link& link) : file(store, link) {}

    OutgoingFile file;
    FixedVector<std::int64_t, limits::max_refine_requests> requests;  ///< keyframes
    CandidateList candidates;
    PassPlan plan;
    PlanWorkspace planning;
  };

  void credit(State& after, const Contact& contact);
  Status begin_pass(State& after, const Contact& contact, bool& begun);
  /// After an older checkpoint was loaded, takes in what is on record after it.
  Status catch_up();

  // Confirmations (downlink_confirmations.cpp)
  Status hear_all();
  Status hear(State& after, bool& heard);
  Status hear_one(DownlinkRecord record, State& after, bool& settled, bool& heard);
  Status hear_layers(const DownlinkRecord& record, ProductRecord product);
  Status drop_if_lost(const DownlinkRecord& record, State& after, bool& settled, bool& heard);
  /// The record of a file was damaged: everything that was sent and is not confirmed is sent again.
  Status check_products(State& after, bool& changed);

  // Choice of the next file; `most` limits its bytes (downlink_choice.cpp).
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
  /// Whether a file of this many bytes may be sent now. If not, its class has a file waiting.
  bool may_go(const State& after, std::int64_t bytes, std::int64_t most);

  // The files (downlink_files.cpp)
  Status send_records(std::int64_t keyframe_id, State& after, bool& sent);
  Status write_depth(std::int64_t keyframe_id);
  Status write_mask(std::int64_t keyframe_id);
  Status write_link(std::int64_t id);
  Status write_products_of(std::int64_t keyframe_id, std::int64_t frame_id);
  Status write_frame(std::int64_t id);
  Status send_points(std::int64_t id, std::int64_t most, State& after, bool& sent);
  Status send_layers(const ProductRecord& product, int last_layer, State& after, bool& sent);
  Status write_refinement(const ProductRecord& product, std::span<const std::uint8_t> longer, int last_layer);
  /// Sends the events after `through`; with `late`, the events of a file that was lost.
  Status send_events(std::int64_t through, bool late, std::int64_t housekeeping_steps, State& after, bool& sent);
  void housekeeping_fingerprint(std::int64_t& steps);
  Status open(const char* name);
  Status close_file(DownlinkRecord sent, State& after);
  void drop_late(const Late& late, State& after);

  Status find_requests();
  /// The first waiting product after `product` whose records have been sent.
  Status next_waiting(const State& after, ProductRecord& product, bool& found);
  [[nodiscard]] bool waits(const State& after, const ProductRecord& product) const;
  Status gather(const State& after);
  [[nodiscard]] bool requested(std::int64_t keyframe_id) const;
  /// Whether a file of this many bytes may be sent before the pass ends.
  [[nodiscard]] bool fits(const State& after, std::int64_t bytes) const;

  /// Sends the next file if there is contact. Loss and return of contact are events.
  Status send_in_contact(State& after, bool& sent);
  StepResult send_one();
  /// A file could not be made or handed over: writes an event, or returns a fault that concerns all files.
  Status set_aside(const Status& fault, bool& others);
  [[nodiscard]] bool given_up(FileClass kind, std::int64_t id) const;
  [[nodiscard]] bool rests(FileClass kind, std::int64_t id) const;

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
  Workspace workspace_;
};

}  // namespace ilp
