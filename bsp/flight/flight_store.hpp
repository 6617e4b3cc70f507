// Opens the store of a flight: its database, a new database if that cannot be used, or memory if the disk fails.
#pragma once

#include <cstddef>
#include <span>

#include "bsp/flight/disk_probe.hpp"
#include "bsp/flight/flight_database.hpp"
#include "fsw/base/arena.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

/// Attempts to open a database on a failing disk, a second apart, before a start with `fly_on` uses memory.
inline constexpr int start_attempts = 10;

class FlightStore final : public StoreSharing {
 public:
  /// `sqlite` is SQLite's arena (configure_sqlite_memory), which lies in `memory`. A store in memory takes all of
  /// `memory`. Both outlive the store.
  FlightStore(const Arena& sqlite, std::span<std::byte> memory) : sqlite_(sqlite), memory_(memory), database_(memory) {}
  /// Calls close().
  ~FlightStore() { close(); }

  /// Opens the database at `path`, or makes it, and takes in the records that a flight in memory has left beside it. A
  /// database whose flight did not end in order is checked completely first. A database that was found damaged in
  /// flight is not opened again. The size is limited to the storage budget of `mission`; a store in memory reduces the
  /// budget. `wait` is called between attempts on a failing disk; if it is null there is one attempt.
  ///
  /// Returns `store_build` if the checkpoints are those of another build, `store_in_use` if another flight has the
  /// database open, `store_damaged` if it is damaged. With `fly_on` only `store_in_use` remains.
  Status open(const char* path, StoreTrouble trouble, MissionParameters& mission, DiskWait* wait = nullptr);
  /// Opens the database as open() does, for the primary of a flight that several processes share. In real time `when`
  /// is `behind_commit`, so that a commit returns when it is on the disk. In virtual time it is `later`, because a
  /// recorded image can be read again. While other processes have the database open, it is neither salvaged nor
  /// quarantined: a database that cannot be used is refused. A store in memory cannot be shared.
  Status open_as_primary(const char* path, StoreTrouble trouble, Synchronise when, const MissionParameters& mission) {
    return database_.open_as_primary(path, trouble, when, mission);
  }
  /// Opens the database for another process of the flight. Returns `not_found` until a primary has made it. The commits
  /// of such a process need not wait for the disk, because its records can be made again from earlier ones, and the
  /// ground gets none of them before they are on the disk (StoreSharing::flush).
  Status join(const char* path, const MissionParameters& mission);
  /// Uses a store in memory without a database; its records end with the process.
  Status begin_in_memory(MissionParameters& mission) { return begin_in_memory(Status{}, mission); }
  /// For a flight in memory whose disk works again (try_disk): writes all records into a file beside the database at
  /// `path` and synchronises it. If it returns ok the process must end, and the next start takes the records in. After
  /// an error of write_memory_copy() the flight continues in memory. Must be called outside a transaction.
  Status leave_memory(const char* path, DiskWait* wait);
  /// Closes the store and releases the guard, with a note if the database is damaged.
  void close() { database_.close(); }

  // StoreSharing
  Status claim(StageMask stages) override { return database_.guard().claim(stages); }
  void release() override { close(); }
  /// A database in a file has no connection that could be lost. See damaged().
  [[nodiscard]] bool connected() const override { return true; }
  Status reconnect() override { return {}; }
  Status flush() override { return in_memory_ ? Status{} : database_.store().flush(); }
  Status flush_own() override { return in_memory_ ? Status{} : sqlite::flush_own(database_.store().session()); }
  /// Polls about every millisecond.
  void wait(std::int32_t milliseconds) override;

  /// The database; null if the store is in memory.
  [[nodiscard]] SqliteStore* disk() { return in_memory_ ? nullptr : &database_.store(); }
  [[nodiscard]] Store& store() { return in_memory_ ? static_cast<Store&>(*ram_) : database_.store(); }
  [[nodiscard]] const StoreUpdates& start() const { return database_.updates(); }
  [[nodiscard]] Status updates() const { return start().database; }
  /// Calls SqliteStore::take_updates(); ok for a store in memory.
  [[nodiscard]] Status take_updates() { return in_memory_ ? Status{} : database_.store().take_updates(); }
  /// Memory for the stack of a DiskProbe, which the store does not use. Empty unless the flight is in memory because
  /// its disk failed.
  [[nodiscard]] std::span<std::byte> look_stack() const { return look_stack_; }
  /// Whether the database was found damaged in flight. Nothing is safely stored then until the next start, which reads
  /// the note in the guard.
  [[nodiscard]] bool damaged() const { return database_.damaged(); }
  [[nodiscard]] const ArenaStats& memory_use() const { return in_memory_ ? ram_->memory() : sqlite_.stats(); }

 private:
  Status begin_in_memory(const Status& fault, MissionParameters& mission);

  const Arena& sqlite_;
  std::span<std::byte> memory_;
  FlightDatabase database_;
  alignas(RamStore) std::byte ram_place_[sizeof(RamStore)];
  RamStore* ram_ = nullptr;
  bool in_memory_ = false;
  std::span<std::byte> look_stack_;
};

}  // namespace ilp
