// Opens the store that the command line names: a database file, memory, or a server.
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
  /// The arguments are those of FlightStore.
  ChosenStore(const Arena& sqlite, std::span<std::byte> memory) : file_(sqlite, memory) {}

  /// For the primary: opens or makes the store and reserves `stages`. If these are not all stages, other processes may
  /// join. The size of the store is limited by the budget of `mission`. `wait` is that of FlightStore::open().
  Status open(const Options& options, StageMask stages, MissionParameters& mission, DiskWait& wait);
  /// For another process of the flight: opens the store, with the same limit, and reserves `stages`. Returns
  /// `not_found` until the primary has made the store.
  Status join(const Options& options, StageMask stages, const MissionParameters& mission);
  void close();

  [[nodiscard]] Store& store();
  [[nodiscard]] StoreSharing& sharing();
  /// The database file; the null pointer for a server or a store in memory.
  [[nodiscard]] SqliteStore* disk() { return server_ ? nullptr : file_.disk(); }
  /// The functions of FlightStore with these names.
  [[nodiscard]] std::span<std::byte> look_stack() const { return file_.look_stack(); }
  Status leave_memory(const char* path, DiskWait* wait) { return file_.leave_memory(path, wait); }
  [[nodiscard]] Status updates() const { return file_.updates(); }
  [[nodiscard]] const StoreUpdates& start() const { return file_.start(); }
  [[nodiscard]] bool damaged() const { return !server_ && file_.damaged(); }
  /// FlightStore::take_updates(); ok for a server.
  [[nodiscard]] Status take_updates() { return server_ ? Status{} : file_.take_updates(); }
  /// The server's message about the latest failed call; "": none.
  [[nodiscard]] const char* message() const;
  /// The store in a file or in memory; it is not open if a server is used.
  [[nodiscard]] const FlightStore& file() const { return file_; }

 private:
  Status connect(const Options& options, bool is_primary, const MissionParameters& mission);

  FlightStore file_;
  bool server_ = false;
#ifdef ILP_POSTGRES
  PostgresStore postgres_;
#endif
};

/// Whether the address of a server contains a password. Such an address must be refused, because other users can see
/// command lines.
[[nodiscard]] bool names_password(const Options& options);
/// Name of the store for messages; it never contains a password.
[[nodiscard]] const char* store_label(const Options& options);

}  // namespace ilp
