// A store that the command line names: a database file, or a server.
#pragma once

#include <memory>
#include <string>

#include "hal/store/sqlite/sqlite_store.hpp"
#include "hal/store/store.hpp"
#ifdef ILP_POSTGRES
#include "hal/store/postgres/postgres_store.hpp"
#endif

namespace ilp::store_tool {

/// `postgresql://...` is a server, every other name a file. Failures are exceptions that say what to do and hold no
/// password; so is a name with a password in it.
class NamedStore {
 public:
  /// Reads only: nothing is made.
  static NamedStore for_reading(const std::string& name);
  /// Makes the tables where there are none. `made`: there were none.
  static NamedStore with_tables(const std::string& name, bool& made);

  [[nodiscard]] Store& store() { return *store_; }

 private:
  std::unique_ptr<SqliteStore> file_;
#ifdef ILP_POSTGRES
  std::unique_ptr<PostgresStore> server_;
#endif
  Store* store_ = nullptr;
};

}  // namespace ilp::store_tool
