// Keeps the store within its budget without losing data that must stay (paper 2; decisions.md, 12).
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/sound_store.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/step_transaction.hpp"
#include "fsw/storage/frame_release.hpp"
#include "fsw/storage/record_history.hpp"
#include "fsw/storage/storage_victims.hpp"

namespace ilp {

/// Limit for the database of a flight: the budget, a quarter of it for pages that are not full, and the records. Its
/// disk must also hold 16 MiB for the log.
[[nodiscard]] constexpr std::int64_t database_limit_bytes(const MissionParameters& mission) {
  return static_cast<std::int64_t>(1.25 * mission.storage_budget_mib * 1048576.0) + (std::int64_t{64} << 20U);
}

/// Data that nobody needs any more is erased at once: images of frames, depth maps once they are coded, and masks,
/// points and products once the ground has confirmed the files that carry them. A full store is a mode: from the high
/// watermark of the budget or of a share down to the low one, it erases points first, the oldest first, then masks
/// whose records were sent without a confirmation, the oldest first, then the last layers of products with the least
/// worth per byte, and when no layer is left, whole products of least priority. Products that were sent stay until they
/// are confirmed. Capture never stops. record_history.hpp has the rules for old records. The places on record count as
/// data with the size that they have at most; their own stage keeps them within their share (place_room.hpp).
class StorageManager final : public StageComponent<ComponentId::storage_manager> {
 public:
  static const CheckpointForm checkpoint;
  using File = std::array<std::uint8_t, limits::max_product_bytes>;
  using Scratch = StepScratch<File>;

  StorageManager(Tables store, const MissionParameters& mission, Scratch scratch);

  Status restore() override;
  StepResult step() override;
  [[nodiscard]] LastingMemory lasting() const override {
    return LastingMemory::of(*this, wiring_, cursor_, state_, work_).changed_by_commits();
  }

 private:
  static constexpr std::int64_t points_window = 1024;
  static constexpr int batch = 8;  ///< records of a kind in one step

  struct Wiring {
    Tables whole;  ///< damaged records included: for the checkpoint
    SoundView<Tables::tables> store;
    const MissionParameters& mission;
    Scratch scratch;
  };
  struct State {
    FrameReleaseState frames;
    std::int64_t counted_depth_id = 0;
    std::int64_t counted_structure_id = 0;
    std::int64_t counted_product_id = 0;
    std::int64_t coded_depth_id = 0;         ///< depth maps up to it are coded and gone
    std::int64_t released_depth_id = 0;      ///< no mask up to it is left
    std::int64_t released_structure_id = 0;  ///< no points up to it are left
    std::int64_t aged_structure_id = 0;      ///< no component needs points up to it any more
    /// Bit k: the ground holds the points of aged_structure_id + 1 + k.
    std::array<std::uint64_t, points_window / 64> points_held{};
    std::int64_t checked_downlink_id = 0;  ///< every file up to it is confirmed and its product deleted
    std::int64_t oldest_product_id = 0;    ///< products before it are erased
    std::int64_t obeyed_command_id = 0;
    RecordHistory history;
    StorageRecord account;
  };
  struct Work {
    VictimSearch search;
    std::int64_t weighed_id = -1;  ///< newest place when place_bytes was found
    std::int64_t place_bytes = 0;  ///< of all places on record, at most
    std::int64_t asked_id = 0;     ///< files up to it have been examined in this round
    std::int64_t swept_id = 0;     ///< products up to it have been examined in this round
    bool searching = false;        ///< the search for data to erase is not complete
    bool gave_up = false;          ///< this search has erased something
    bool round_done = false;       ///< every file that is not confirmed has been examined
    bool rounds_done = false;      ///< both rounds are done since the last change
    bool searches_done = false;
  };
  /// What one step changes, in memory only.
  struct Draft {
    State after;
    bool changed = false;
    Status event;
    StoreUsage usage;
  };

  Status recount();
  Status count_new(Draft& draft);
  Status weigh_places();
  Status release(Draft& draft);
  Status release_depth(Draft& draft);
  Status count_depth(Draft& draft);
  Status find_mask(std::int64_t keyframe_id, MaskRecord& mask);
  Status release_mask(MaskRecord mask, Draft& draft);
  Status release_points(StructureRecord structure, bool held, Draft& draft);
  Status age_points(Draft& draft);
  /// Releases the oldest points left: old ones according to the history, newer ones too if `full`.
  Status release_oldest_points(bool full, Draft& draft, bool& released);
  Status release_oldest_mask(bool full, Draft& draft, bool& released);
  Status unneeded_before(std::int64_t& keyframe_id);
  Status obey_commands(Draft& draft);
  Status delete_acknowledged(Draft& draft);
  /// `settled`: no further action on it is needed.
  Status settle(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft, bool& settled);
  Status settle_records(const DownlinkRecord& sent, Draft& draft, bool& settled);
  Status settle_points(const DownlinkRecord& sent, Draft& draft, bool& settled);
  Status settle_product(const DownlinkRecord& sent, TimeNs newest_sent_ns, Draft& draft);
  Status send_again(const DownlinkRecord& lost, ProductRecord product, Draft& draft);
  Status sweep(Draft& draft);
  Status delete_product(const ProductRecord& product, Draft& draft);
  Status give_up(ProductRecord product, Draft& draft);
  Status give_up_damaged(const ProductRecord& product, Draft& draft);
  Status thin_frames(Draft& draft);
  Status note_mode(Draft& draft);
  Status give_up_least(Draft& draft);
  Status cut_last_layer(ProductRecord product, Draft& draft, bool& done);
  Status drop(const ProductRecord& product, Draft& draft);
  Status find_oldest(Draft& draft);
  Status work_through(Draft& draft);
  /// Whether all files and, in a full store, all products have been examined since a change. The two rounds run step by
  /// step and independently: a complete round does not start again because the other is not complete.
  bool looked_through();
  [[nodiscard]] double share(double part) const;
  [[nodiscard]] std::int64_t held_bytes(const StorageRecord& account) const;
  /// Whether products exceed this fraction of the budget, of their share, or of the database's limit, whose pages small
  /// products do not fill.
  [[nodiscard]] bool products_above(const Draft& draft, double watermark) const;

  Wiring wiring_;
  Cursor cursor_;
  State state_;
  Work work_;
};

}  // namespace ilp
