// Opens the database file of a flight, salvages or quarantines one that cannot be used, and takes in the records that
// flights in memory have left beside it.
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

/// What to do if the database cannot be used.
enum class StoreTrouble : std::uint8_t {
  refuse,  ///< opening fails, and the database is not changed
  /// The readable part of a damaged database is saved into a new one. A database of another version or build is
  /// quarantined and replaced by a new one. After any other fault, which shows nothing about the content, the database
  /// is not changed, and the flight has its store in memory.
  fly_on
};

/// What to do with a memory copy that cannot be read: fail, because the disk may read it on another attempt, or
/// quarantine it.
enum class UnreadableCopy : std::uint8_t { try_again, quarantine };

/// What happened when the store was opened. Each status is ok if it does not apply.
struct StoreUpdates {
  /// Why the flight does not use its previous database: `store_salvaged`, `store_set_aside` or `store_in_memory`; or
  /// `log_damaged` if its log was damaged and repaired. The events of a salvaged database list the losses by table.
  Status database;
  Status moved;        ///< `store_back_on_disk`: records of a flight in memory were moved into the database
  Status not_moved;    ///< `store_not_moved`: such records could not be used; their file is kept for the ground
  Status opened_late;  ///< `store_opened_late`: earlier attempts to open the database had failed
  SalvageCounts salvaged{};

  [[nodiscard]] std::array<Status, 4> in_order() const { return {opened_late, database, moved, not_moved}; }
};

/// Whether a fault may pass by itself, as those of the disk. All other faults are verdicts on the content.
[[nodiscard]] bool may_pass(const Status& fault);

/// FlightStore describes the three ways to open the database.
class FlightDatabase {
 public:
  /// The salvage uses the end of `memory`, where SQLite's arena does not reach.
  explicit FlightDatabase(std::span<std::byte> memory) : memory_(memory) {}

  Status open(const char* path, StoreTrouble trouble, const MissionParameters& mission, DiskWait* wait,
              UnreadableCopy copies);
  Status open_as_primary(const char* path, StoreTrouble trouble, Synchronise when, const MissionParameters& mission);
  Status open_among_others(const char* path, const MissionParameters& mission, Synchronise when);
  /// Closes the database and releases the guard, with a note if the database is damaged.
  void close();

  [[nodiscard]] SqliteStore& store() { return store_; }
  [[nodiscard]] DatabaseGuard& guard() { return guard_; }
  [[nodiscard]] StoreUpdates& updates() { return updates_; }
  [[nodiscard]] const StoreUpdates& updates() const { return updates_; }
  /// Whether the database was found damaged. If so, the guard gets a note.
  [[nodiscard]] bool damaged() const;

 private:
  /// Replaces the database by a new one with its readable records, or by an empty one, and quarantines it.
  Status replace(const char* path, const Status& verdict, const MissionParameters& mission);
  /// Quarantines the database if a complete salvaged one exists, and renames that to `path`.
  Status put_saved_in_place(const char* path);
  /// Opens the database, repaired or replaced if `trouble` allows.
  Status open_usable(const char* path, StoreTrouble trouble, const MissionParameters& mission);
  /// Takes all memory copies beside the database into it.
  Status take_in_copies(const char* path, const MissionParameters& mission, DiskWait* wait, UnreadableCopy copies);
  Status take_in(const char* path, const char* copy, const MissionParameters& mission, DiskWait* wait,
                 UnreadableCopy copies);

  std::span<std::byte> memory_;
  SqliteStore store_;
  mutable DatabaseGuard guard_;  ///< damaged() writes the note in it
  StoreUpdates updates_;
};

}  // namespace ilp
