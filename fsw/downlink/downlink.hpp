// Sends the most valuable products and receives the confirmations: Product -> Acknowledged (file formats:
// docs/outbox.md).
#pragma once

#include "fsw/downlink/downlink_part.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/shared/step_transaction.hpp"

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
/// A file that fails is quarantined and delays no other file; it is tried again after growing pauses. If the store
/// still answers, the file is abandoned after 12 such faults, or after 3 permanent ones: a product is marked as
/// damaged, records are sent without the unreadable ones, points and single events are left out, each with an event.
/// Files that the link refuses are never abandoned. Confirmations are committed separately, before anything is sent.
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
  using State = DownlinkState;

  void credit(State& after, const Contact& contact);
  Result<bool> begin_pass(State& after, const Contact& contact);
  /// After an older checkpoint was loaded, takes in what is on record after it.
  Status catch_up();

  Status confirm_all();
  /// Sends the next file if there is contact. Loss and return of contact are events.
  Result<bool> send_in_contact(State& after);
  StepResult send_one();
  /// A file could not be made or handed over: writes an event, or returns a fault that concerns all files.
  StepResult quarantine(const Status& fault);
  template <typename Part>
  Part part() {
    return Part(wiring_, cursor_, state_, work_, workspace_);
  }

  DownlinkWiring wiring_;
  Cursor cursor_;
  State state_;
  DownlinkWork work_;
  DownlinkWorkspace workspace_;
};

}  // namespace ilp
