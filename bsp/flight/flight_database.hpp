// The database file of a flight: opened, saved or quarantined, with what flights in memory have left beside it.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "bsp/flight/database_guard.hpp"
#include "bsp/flight/memory_copy.hpp"
#include "cfg/mission.hpp"
#include "hal/store/sqlite/salvage.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"

namespace ilp {

enum class StoreTrouble : std::uint8_t {
  refuse,  ///< open() fails, and nothing is touched
  /// The readable part of a damaged database is saved into a new one; a database of another version or build is set
  /// aside for a new one. After any other fault, which says nothing about its content, a database stays where it is,
  /// and the flight has a store in memory.
  fly_on
};

/// What to do with a copy of records in memory that cannot be read: on another attempt the disk may read it.
enum class UnreadableCopy : std::uint8_t { try_again, quarantine };

/// Of the start of a store; ok: nothing has happened.
struct StoreUpdates {
  /// The reason why the flight does not use its database: `store_salvaged`, `store_set_aside` or `store_in_memory`; or
  /// `log_damaged`, if its log was damaged and is mended. The events of a salvaged database list the losses by table.
  Status database;
  Status moved;        ///< `store_back_on_disk`: records of a flight in memory were moved into the database
  Status not_moved;    ///< `store_not_moved`: such records could not be used. Their file is kept for the ground
  Status opened_late;  ///< `store_opened_late`: the disk had failed at first
  SalvageCounts salvaged{};

  [[nodiscard]] std::array<Status, 4> in_order() const { return {opened_late, database, moved, not_moved}; }
};

/// A fault of the disk that passes; the others are verdicts on the content.
[[nodiscard]] bool may_pass(const Status& fault);

/// FlightStore describes the ways to open it.
class FlightDatabase {
 public:
  /// `memory` is free for the salvage where SQLite's arena does not reach.
  explicit FlightDatabase(std::span<std::byte> memory) : memory_(memory) {}

  Status open(const char* path, StoreTrouble trouble, const MissionParameters& mission, DiskWait* wait,
              UnreadableCopy copies);
  Status open_as_primary(const char* path, StoreTrouble trouble, Synchronise when, const MissionParameters& mission);
  Status open_among_others(const char* path, const MissionParameters& mission, Synchronise when);
  /// Notes damage.
  void close();

  [[nodiscard]] SqliteStore& store() { return store_; }
  [[nodiscard]] DatabaseGuard& guard() { return guard_; }
  [[nodiscard]] StoreUpdates& updates() { return updates_; }
  [[nodiscard]] const StoreUpdates& updates() const { return updates_; }
  /// Notes it.
  [[nodiscard]] bool damaged() const;

 private:
  Status replace(const char* path, const Status& verdict, const MissionParameters& mission);
  Status put_saved_in_place(const char* path);
  Status open_usable(const char* path, StoreTrouble trouble, const MissionParameters& mission);
  Status take_in_copies(const char* path, const MissionParameters& mission, DiskWait* wait, UnreadableCopy copies);
  Status take_in(const char* path, const char* copy, const MissionParameters& mission, DiskWait* wait,
                 UnreadableCopy copies);

  std::span<std::byte> memory_;
  SqliteStore store_;
  mutable DatabaseGuard guard_;  ///< damaged() writes the note in it
  StoreUpdates updates_;
};

}  // namespace ilp
