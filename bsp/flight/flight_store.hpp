// Which store a flight has: its database, a new one where that cannot be used, or memory where there is no disk.
#pragma once

#include <cstddef>
#include <span>

#include "bsp/flight/database_guard.hpp"
#include "cfg/mission.hpp"
#include "fsw/base/arena.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/sqlite/salvage.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {

enum class StoreTrouble : std::uint8_t {
  refuse,  ///< open() fails, and nothing is touched
  /// What can be read of a damaged database is saved into a new one; one that cannot be used at all is set aside;
  /// without a disk the flight has a store in memory.
  fly_on
};

class FlightStore {
 public:
  /// SQLite has been given `sqlite` (configure_sqlite_memory), which lies in `memory`; without a disk the records
  /// themselves take all of it. Both outlive the store.
  FlightStore(const Arena& sqlite, std::span<std::byte> memory) : sqlite_(sqlite), memory_(memory) {}
  /// Leaves word of damage, as close() does.
  ~FlightStore() { close(); }
  FlightStore(const FlightStore&) = delete;
  FlightStore& operator=(const FlightStore&) = delete;

  /// A database with the checkpoints of another build is refused with `store_build`, one that another flight has open
  /// with `store_in_use`. One whose flight did not end in order is read through first (`store_damaged`), and one that
  /// was found damaged in flight is not opened again. What the flight may keep is limited to the budget of `mission`,
  /// which a store in memory makes smaller.
  Status open(const char* path, StoreTrouble trouble, MissionParameters& mission);
  void close();

  [[nodiscard]] Store& store() { return in_memory_ ? static_cast<Store&>(*ram_) : disk_; }
  /// Why the flight has not the database that it was told to have: `store_salvaged`, `store_set_aside` or
  /// `store_in_memory`; or `log_damaged`, where its log was damaged and is mended; else ok. What was lost by table
  /// stands in the events of a salvaged database.
  [[nodiscard]] Status news() const { return news_; }
  /// Of the salvage at this start.
  [[nodiscard]] const SalvageCounts& salvaged() const { return salvaged_; }
  /// The database was found damaged in flight: nothing can be trusted to be kept until the next start, which learns of
  /// it.
  [[nodiscard]] bool damaged() const;
  [[nodiscard]] const ArenaStats& memory_use() const { return in_memory_ ? ram_->memory() : sqlite_.stats(); }

 private:
  Status open_database(const char* path);
  Status begin_anew(const char* path, const Status& fault);
  Status save(const char* path, const Status& fault, const MissionParameters& mission);
  Status put_saved_in_place(const char* path);
  Status open_usable(const char* path, StoreTrouble trouble, const MissionParameters& mission);
  Status begin_in_memory(const Status& fault, MissionParameters& mission);

  const Arena& sqlite_;
  std::span<std::byte> memory_;
  SqliteStore disk_;
  alignas(RamStore) std::byte ram_place_[sizeof(RamStore)];
  RamStore* ram_ = nullptr;
  bool in_memory_ = false;
  mutable DatabaseGuard guard_;  ///< damaged() leaves word in it
  SalvageCounts salvaged_{};
  Status news_;
};

}  // namespace ilp
