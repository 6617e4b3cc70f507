// The data of StorageManager, and the base class of its parts: products, and other data that are released.
#pragma once

#include <array>

#include "cfg/mission.hpp"
#include "fsw/executive/stage_component.hpp"
#include "fsw/shared/checkpoint.hpp"
#include "fsw/shared/step_memory.hpp"
#include "fsw/shared/valid_store.hpp"
#include "fsw/storage/frame_release.hpp"
#include "fsw/storage/record_history.hpp"
#include "fsw/storage/storage_victims.hpp"

namespace ilp {

using StorageTables = StageStore<ComponentId::storage_manager>;
using StorageFile = std::array<std::uint8_t, limits::max_product_bytes>;

inline constexpr std::int64_t points_window = 1024;
inline constexpr int storage_batch = 8;  ///< most records of a kind in one step

struct StorageWiring {
  StorageTables whole;  ///< the store with damaged records, for the checkpoint
  ValidView<StorageTables::tables> store;
  const MissionParameters& mission;
  StepScratch<StorageFile> scratch;
};
struct StorageState {
  FrameReleaseState frames;
  std::int64_t counted_depth_id = 0;
  std::int64_t counted_structure_id = 0;
  std::int64_t counted_product_id = 0;
  std::int64_t coded_depth_id = 0;         ///< depth maps up to this one are coded and erased
  std::int64_t released_depth_id = 0;      ///< masks up to this one are released
  std::int64_t released_structure_id = 0;  ///< points up to this structure are released
  std::int64_t aged_structure_id = 0;      ///< no component needs points up to this structure any more
  /// Bit k: the ground has confirmed the points of structure aged_structure_id + 1 + k.
  std::array<std::uint64_t, points_window / 64> points_held{};
  std::int64_t checked_downlink_id = 0;  ///< files up to this one are confirmed, and their products are erased
  std::int64_t oldest_product_id = 0;    ///< products before this one are erased
  std::int64_t obeyed_command_id = 0;
  RecordHistory history;
  StorageRecord account;
};
struct StorageWork {
  VictimSearch search;
  bool weighed = false;          ///< `place_bytes` is valid
  std::int64_t weighed_id = 0;   ///< newest place when `place_bytes` was determined
  std::int64_t place_bytes = 0;  ///< most bytes of all places on record
  std::int64_t asked_id = 0;     ///< files up to this one have been examined in this round
  std::int64_t swept_id = 0;     ///< products up to this one have been examined in this round
  bool searching = false;        ///< the search for data to erase is not complete
  bool has_abandoned = false;    ///< this search has erased something
  bool round_done = false;       ///< every unconfirmed file has been examined
  bool rounds_done = false;      ///< both rounds were completed since the last change
  bool searches_done = false;
};
/// The changes of one step, which take effect in memory after the commit.
struct StorageDraft {
  StorageState after;
  bool changed = false;
  Status event;
  StoreUsage usage;
};

class StoragePart {
 public:
  using Draft = StorageDraft;
  using State = StorageState;

  StoragePart(const StorageWiring& wiring, StorageWork& work) : wiring_(wiring), work_(work) {}

  /// Bytes of a part of the storage budget.
  [[nodiscard]] double share(double part) const;
  [[nodiscard]] std::int64_t held_bytes(const StorageRecord& account) const;
  /// Whether products exceed the fraction `watermark` of the budget, of their share, or of the database's limit (small
  /// products do not fill its pages).
  [[nodiscard]] bool products_above(const Draft& draft, double watermark) const;

 protected:
  static constexpr int batch = storage_batch;

  const StorageWiring& wiring_;
  StorageWork& work_;
};

}  // namespace ilp
