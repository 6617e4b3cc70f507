// Which store a flight has: its database, a new one where that cannot be used, or memory where there is no disk.
#pragma once

#include <cstddef>
#include <span>

#include "cfg/mission.hpp"
#include "fsw/base/arena.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {

enum class StoreTrouble : std::uint8_t {
  refuse,  ///< open() fails, and nothing is touched
  fly_on   ///< a database that cannot be used is set aside; without a disk the flight has a store in memory
};

class FlightStore {
 public:
  /// SQLite has been given `sqlite` (configure_sqlite_memory), which lies in `memory`; without a disk the records
  /// themselves take all of it. Both outlive the store.
  FlightStore(const Arena& sqlite, std::span<std::byte> memory) : sqlite_(sqlite), memory_(memory) {}

  /// A database with the checkpoints of another build is refused with `store_build`. One whose flight did not end in
  /// order is read through first (`store_damaged`). What the flight may keep is
  /// limited to the budget of `mission`, which a store in memory makes smaller.
  Status open(const char* path, StoreTrouble trouble, MissionParameters& mission);
  void close();

  [[nodiscard]] Store& store() { return in_memory_ ? static_cast<Store&>(*ram_) : disk_; }
  /// Why the flight has not the database that it was told to have: `store_set_aside` or `store_in_memory`, else ok.
  [[nodiscard]] Status news() const { return news_; }
  /// The database was found damaged in flight: nothing can be trusted to be kept until the next start.
  [[nodiscard]] bool damaged() const { return disk_.damaged(); }
  [[nodiscard]] const ArenaStats& memory_use() const { return in_memory_ ? ram_->memory() : sqlite_.stats(); }

 private:
  Status open_database(const char* path);
  Status begin_anew(const char* path, const Status& fault);
  Status begin_in_memory(const Status& fault, MissionParameters& mission);

  const Arena& sqlite_;
  std::span<std::byte> memory_;
  SqliteStore disk_;
  alignas(RamStore) std::byte ram_place_[sizeof(RamStore)];
  RamStore* ram_ = nullptr;
  bool in_memory_ = false;
  Status news_;
};

}  // namespace ilp
