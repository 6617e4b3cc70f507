// Sends what is worth most and hears what has arrived: Product -> Acknowledged (file formats: docs/outbox.md).
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/components/checkpoint.hpp"
#include "fsw/components/outgoing_file.hpp"
#include "fsw/components/pass_planner.hpp"
#include "fsw/executive/component.hpp"
#include "fsw/link/pass_schedule.hpp"
#include "hal/clock/clock.hpp"

namespace ilp {

/// One file a step, within the link's mean rate, during passes only. In this order: the first layers of products that
/// have waited too long (within a quarter of a pass, oldest first), the records of keyframes, products as plan_pass
/// puts them, sparse points, events when there are enough of them or time has passed. With downlink_order = 1 whole
/// products in the order of their keyframes instead. A product goes as its first
/// layers, later refined by the rest; it is done with only when the ground has confirmed size and CRC of every file of
/// it. Without contact everything waits.
///
/// Nothing waits for ever: of the products that were there `overdue_passes` passes ago and of which nothing has gone,
/// every pass sends the oldest, and as many more as fit into a quarter of it. So the first layer of a product goes at
/// the latest in the pass overdue_passes + 1 + n after it was made, where n counts the older products and records that
/// were waiting then (as long as no file is larger than a pass).
class Downlink final : public Component {
 public:
  static const CheckpointForm checkpoint;

  Downlink(Store& store, Link& link, Clock& clock, const MissionParameters& mission);

  [[nodiscard]] const char* name() const override { return "downlink"; }
  Status restore() override;
  StepResult step(TimeNs deadline) override;
  [[nodiscard]] LastingMemory lasting() const override { return LastingMemory(cursor_, state_); }

  /// Everything that there is has been sent, and confirmed.
  [[nodiscard]] bool drained() const { return drained_; }

 private:
  struct State {
    std::int64_t credit_bytes = 0;  ///< what the link can take now; negative after a large file
    TimeNs credited_ns = 0;
    std::int64_t last_downlink_id = 0;
    std::int64_t records_through = 0;  ///< keyframes up to it have been sent as records
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
  };

  void credit(State& after, const Contact& contact);
  Status begin_pass(State& after, const Contact& contact, bool& begun);
  Status hear(State& after, bool& heard);
  Status hear_product(const DownlinkRecord& record);

  Status send_next(State& after, bool& sent);
  Status send_overdue(State& after, bool& sent);
  Status send_planned(State& after, bool& sent);
  Status send_in_order(State& after, bool& sent);
  Status send_next_records(State& after, bool& sent);
  Status send_next_points(State& after, bool& sent);
  Status send_events_if_due(State& after, bool& sent);

  Status send_records(std::int64_t keyframe_id, State& after);
  Status write_products_of(std::int64_t keyframe_id);
  Status send_layers(const ProductRecord& product, int last_layer, State& after);
  Status write_refinement(const ProductRecord& product, std::span<const std::uint8_t> longer, int last_layer);
  Status send_events(std::int64_t housekeeping_steps, State& after);
  Status housekeeping_fingerprint(std::int64_t& steps);

  Status find_requests();
  /// The first product behind `product` that waits and whose records have gone.
  Status next_waiting(const State& after, ProductRecord& product, bool& found);
  Status gather(const State& after);
  [[nodiscard]] bool requested(std::int64_t keyframe_id) const;
  /// Whether a file of so many bytes may go before the pass ends.
  [[nodiscard]] bool fits(const State& after, std::int64_t bytes) const;

  /// Sends the next file, if there is contact; its loss and its return are events.
  Status send_in_contact(State& after, bool& sent);
  Status open(const char* name);
  Status close_file(DownlinkRecord sent, State& after);

  Store& store_;
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
  std::int64_t room_bytes_ = 0;     ///< that the link can still take in this pass
  OutgoingFile file_;
  FixedVector<std::int64_t, limits::max_refine_requests> requests_;  ///< keyframes
  CandidateList candidates_;
  PassPlan plan_;
  PlanWorkspace workspace_;
  std::array<std::uint8_t, limits::max_product_bytes> product_{};
};

}  // namespace ilp
