// Chooses the store of a flight: its database, a new one if that cannot be used, or memory if there is no disk.
#pragma once

#include <cstddef>
#include <span>

#include "bsp/flight/disk_probe.hpp"
#include "bsp/flight/flight_database.hpp"
#include "fsw/base/arena.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

/// With `fly_on` a start tries a disk that fails this often, a second apart, before it flies in memory.
inline constexpr int start_attempts = 10;

class FlightStore final : public StoreSharing {
 public:
  /// SQLite uses `sqlite` (configure_sqlite_memory), which lies in `memory`. Without a disk the records take all of
  /// `memory`. Both outlive the store.
  FlightStore(const Arena& sqlite, std::span<std::byte> memory) : sqlite_(sqlite), memory_(memory), database_(memory) {}
  /// Notes damage, as close() does.
  ~FlightStore() { close(); }

  /// Refuses a database with the checkpoints of another build with `store_build`, and one that another flight has open
  /// with `store_in_use`. A database whose flight did not end in order is checked completely first (`store_damaged`),
  /// and one that was found damaged in flight is not opened again. The capacity of the flight is limited to the budget
  /// of `mission`, which a store in memory reduces. Without `wait` the first fault of the disk counts. Records that a
  /// flight in memory has left beside the database are taken into it.
  Status open(const char* path, StoreTrouble trouble, MissionParameters& mission, DiskWait* wait = nullptr);
  /// The same for the primary of a flight that several processes share. `when`: in real time `behind_commit`, so that
  /// its commits are on the disk when they are done; in virtual time `later`, because a recorded image can be read
  /// again. While others have the database open, nothing of it is saved or quarantined: a database that cannot be used
  /// is refused. There is no sharing of a store in memory.
  Status open_as_primary(const char* path, StoreTrouble trouble, Synchronise when, const MissionParameters& mission) {
    return database_.open_as_primary(path, trouble, when, mission);
  }
  /// The same for another process of the flight. `not_found` until a primary has made the database. Its commits wait
  /// for no disk: what it makes follows from earlier records, and nobody outside has been told of it
  /// (StoreSharing::flush).
  Status join(const char* path, const MissionParameters& mission);
  /// No database: the records are in memory and end with the process.
  Status begin_in_memory(MissionParameters& mission) { return begin_in_memory(Status{}, mission); }
  /// For a flight in memory, when its disk serves again (try_disk): writes all records beside the database at `path`,
  /// synchronised. With ok the process ends, and the next start takes them in; otherwise the flight goes on in memory.
  /// Outside of transactions. Faults as write_memory_copy().
  Status leave_memory(const char* path, DiskWait* wait);
  void close() { database_.close(); }

  // StoreSharing
  Status claim(StageMask stages) override { return database_.guard().claim(stages); }
  void release() override { close(); }
  /// A database in a file has no connection that could be lost. See damaged().
  [[nodiscard]] bool connected() const override { return true; }
  Status reconnect() override { return {}; }
  Status flush() override { return in_memory_ ? Status{} : database_.store().flush(); }
  Status flush_own() override { return in_memory_ ? Status{} : sqlite::flush_own(database_.store().session()); }
  /// Looks every millisecond.
  void wait(std::int32_t milliseconds) override;

  /// The database, where there is one.
  [[nodiscard]] SqliteStore* disk() { return in_memory_ ? nullptr : &database_.store(); }
  [[nodiscard]] Store& store() { return in_memory_ ? static_cast<Store&>(*ram_) : database_.store(); }
  [[nodiscard]] const StoreUpdates& start() const { return database_.updates(); }
  [[nodiscard]] Status updates() const { return start().database; }
  /// As SqliteStore::take_updates().
  [[nodiscard]] Status take_updates() { return in_memory_ ? Status{} : database_.store().take_updates(); }
  /// Of a flight in memory whose disk failed: the stack of a DiskProbe. Its store leaves it free.
  [[nodiscard]] std::span<std::byte> look_stack() const { return look_stack_; }
  /// The database was found damaged in flight: nothing is safely stored until the next start, which reads the note of
  /// it.
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
