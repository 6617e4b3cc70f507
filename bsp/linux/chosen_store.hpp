// The store that the command line names: a database file, memory, or a server.
#pragma once

#include "bsp/flight/flight_store.hpp"
#include "bsp/flight/stage_set.hpp"
#include "bsp/linux/options.hpp"
#ifdef ILP_POSTGRES
#include "hal/store/postgres/postgres_store.hpp"
#endif

namespace ilp {

class ChosenStore {
 public:
  /// As FlightStore: `sqlite` is SQLite's part of `memory`, and both outlive the store.
  ChosenStore(const Arena& sqlite, std::span<std::byte> memory) : file_(sqlite, memory) {}

  /// For the process that has the camera. It reserves `stages`; if these are not all, others may join. The store is
  /// limited to the budget of `mission`, also for a process that joins. `wait`: as FlightStore::open().
  Status open(const Options& options, StageMask stages, MissionParameters& mission, DiskWait& wait);
  /// For another process of the flight: `not_found` until the primary has made the store. It reserves `stages`.
  Status join(const Options& options, StageMask stages, const MissionParameters& mission);
  void close();

  [[nodiscard]] Store& store();
  [[nodiscard]] StoreSharing& sharing();
  /// The database file; the null pointer for a server, or memory.
  [[nodiscard]] SqliteStore* disk() { return server_ ? nullptr : file_.disk(); }
  /// As FlightStore::look_stack(), leave_memory(), updates(), start() and damaged().
  [[nodiscard]] std::span<std::byte> look_stack() const { return file_.look_stack(); }
  Status leave_memory(const char* path, DiskWait* wait) { return file_.leave_memory(path, wait); }
  [[nodiscard]] Status updates() const { return file_.updates(); }
  [[nodiscard]] const StoreUpdates& start() const { return file_.start(); }
  [[nodiscard]] bool damaged() const { return !server_ && file_.damaged(); }
  /// As FlightStore::take_updates().
  [[nodiscard]] Status take_updates() { return server_ ? Status{} : file_.take_updates(); }
  /// Why the latest call of a server failed, in its own words; "" if it has none.
  [[nodiscard]] const char* message() const;
  /// The store in a file or in memory, also if a server is used.
  [[nodiscard]] const FlightStore& file() const { return file_; }

 private:
  Status connect(const Options& options, bool is_primary, const MissionParameters& mission);

  FlightStore file_;
  bool server_ = false;
#ifdef ILP_POSTGRES
  PostgresStore postgres_;
#endif
};

/// Whether the address of a server holds a password, which it must not: others can see command lines.
[[nodiscard]] bool names_password(const Options& options);
/// How messages name the store: never with a password.
[[nodiscard]] const char* store_label(const Options& options);

}  // namespace ilp
