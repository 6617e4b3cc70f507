// Keeps the store within its budget without losing data that must stay (paper 2; decisions.md, 12).
#pragma once

#include "fsw/shared/step_transaction.hpp"
#include "fsw/storage/storage_products.hpp"
#include "fsw/storage/storage_release.hpp"

namespace ilp {

/// Limit for the size of a flight's database: the storage budget, a quarter of it for pages that are not full, and 64
/// MiB for the records. The disk must have 16 MiB more for the log.
[[nodiscard]] constexpr std::int64_t database_limit_bytes(const MissionParameters& mission) {
  return static_cast<std::int64_t>(1.25 * mission.storage_budget_mib * 1048576.0) + (std::int64_t{64} << 20U);
}

/// Data that are no longer needed are erased at once: images of frames, depth maps once they are coded, and masks,
/// points and products once the ground has confirmed the files that contain them.
///
/// When the data exceed the high watermark of the budget or of a share, the component erases further data until they
/// are below the low watermark, in this order:
/// - points, the oldest first;
/// - masks whose records were sent and not confirmed, the oldest first;
/// - the last layers of products, those with the least utility per byte first;
/// - complete products, those with the least priority first.
/// Products that were sent stay until they are confirmed. Capture never stops. record_history.hpp has the rules for old
/// records. Places count with their largest possible size; the stage that makes them keeps them within their share
/// (place_capacity.hpp).
class StorageManager final : public StageComponent<ComponentId::storage_manager> {
 public:
  static const CheckpointForm checkpoint;
  using Scratch = StepScratch<StorageFile>;

  StorageManager(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_).changed_by_commits();
  }

 private:
  using State = StorageState;
  using Draft = StorageDraft;

  Status recount();
  Status count_new(Draft& draft);
  /// Determines the bytes of all places.
  Status weigh_places();
  Status count_depth(Draft& draft);
  Status obey_commands(Draft& draft);
  Status delete_acknowledged(Draft& draft);
  /// Releases the data of a confirmed file. Returns whether no further action on the file is needed.
  Result<bool> release_confirmed(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft);
  Status thin_frames(Draft& draft);
  Status note_mode(Draft& draft);
  Status work_through(Draft& draft);
  /// Whether all files and, in a full store, all products have been examined since the last change. The two rounds run
  /// step by step and independently: a complete round does not start again while the other one is incomplete.
  bool scanned();
  StorageProducts products() { return {wiring_, work_}; }
  StorageRelease release_part() { return {wiring_, work_}; }

  StorageWiring wiring_;
  Cursor cursor_;
  State state_;
  StorageWork work_;
};

}  // namespace ilp
