// Opens a store that the command line names: a database file or a server.
#pragma once

#include <memory>
#include <string>

#include "hal/store/sqlite/sqlite_store.hpp"
#include "hal/store/store.hpp"
#ifdef ILP_POSTGRES
#include "hal/store/postgres/postgres_store.hpp"
#endif

namespace ilp::store_tool {

/// A name `postgresql://...` is a server; all others are files. Failures throw exceptions with advice and without
/// passwords. A name that contains a password is refused in the same way.
class NamedStore {
 public:
  /// Opens the store for reading. Creates nothing.
  static NamedStore for_reading(const std::string& name);
  /// Opens the store and creates missing tables. `made`: there were none before.
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
