// Sends the products of most utility and receives their confirmations: Product -> Acknowledged (file formats:
// docs/outbox.md).
#pragma once

#include "fsw/downlink/downlink_part.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/shared/step_transaction.hpp"

namespace ilp {

inline constexpr std::int64_t events_per_file = 64;

/// Sends one file per step, within the link's mean rate and only during passes. A file is chosen only when the link has
/// less than one second of work left at this rate, because a chosen file cannot be overtaken by a more important one.
/// The order is:
/// - the first layers of products that have waited too long, oldest first, in at most a quarter of a pass;
/// - classes that have not had their share of the link (cfg/link_shares.hpp);
/// - the records of keyframes;
/// - products in the order of plan_pass;
/// - sparse points;
/// - events, when there are enough of them or enough time has passed.
/// With downlink_order = 1 complete products are sent in the order of their keyframes instead. Otherwise the first
/// layers of a product are sent first, and further files refine them. A product is acknowledged only when the ground
/// has confirmed size and CRC of each of its files. Without contact nothing is sent. Records, points and events whose
/// confirmation is overdue are sent again; for products the storage manager decides this.
///
/// Shares: every file that is sent gives each class its share of the file's bytes as a credit, and takes the file's
/// bytes from the credit of its own class. A class whose credit covers its next file has precedence; among several, the
/// one with the largest credit. On a permanently busy link, a class that has files thus gets its share of all bytes, to
/// within one file.
///
/// A file that fails is quarantined and tried again after growing pauses; it delays no other file. If the store still
/// answers, the file is abandoned after 12 transient or 3 permanent faults, with an event: a product is marked as
/// damaged, records are sent without the unreadable ones, and points and single events are left out. Files that the
/// link refuses are never abandoned. Confirmations are committed separately, before anything is sent.
///
/// No product waits for ever. Consider the products that existed `overdue_passes` passes ago and of which nothing has
/// been sent: every pass sends the oldest of them, and as many more as fit into a quarter of the pass. The first layer
/// of a product is therefore sent at the latest in pass overdue_passes + 1 + n after the product was made, where n is
/// the number of older products and records that were waiting then (provided that no file is larger than a pass).
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

  /// Whether everything has been sent and confirmed.
  [[nodiscard]] bool drained() const { return work_.drained; }

 private:
  using State = DownlinkState;

  /// Adds the bytes that the link could carry since the last call to the credit.
  void credit(State& after, const Contact& contact);
  /// Resets the counts of a pass if a new one has begun. Returns whether it has.
  Result<bool> begin_pass(State& after, const Contact& contact);
  /// Brings the state up to the records that were written after the checkpoint.
  Status catch_up();

  /// Reads confirmations and commits them.
  Status confirm_all();
  /// Sends the next file if there is contact. Loss and return of contact are events.
  Result<bool> send_in_contact(State& after);
  StepResult send_one();
  /// Quarantines the present file after `fault`, with an event. Returns `fault` if it concerns all files.
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
