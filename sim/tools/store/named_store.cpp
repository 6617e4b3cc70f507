#include "sim/tools/store/named_store.hpp"

#include <filesystem>
#include <stdexcept>

#include "sim/host/status_error.hpp"

namespace ilp::store_tool {
namespace {

bool is_server(const std::string& name) {
  return name.rfind("postgresql://", 0) == 0 || name.rfind("postgres://", 0) == 0;
}

[[noreturn]] void fail(const std::string& what, const Status& status) {
  throw std::runtime_error(what + ": " + host::describe(status));
}

#ifdef ILP_POSTGRES
std::unique_ptr<PostgresStore> connect(const std::string& name, bool create) {
  if (holds_password(name.c_str())) {
    throw std::runtime_error(
        "the name of the store holds a password, which every user of this machine can read: put it into the file that "
        "PGPASSFILE names, or ~/.pgpass");
  }
  auto store = std::make_unique<PostgresStore>();
  const Status status = store->open(name.c_str(), 0, {.create = create});
  if (status.is(StatusCode::not_found)) {
    throw std::runtime_error(name + ": the database has no tables of a flight: make them with `ilp-store create`");
  }
  if (status.is(StatusCode::store_schema) && status.a == -1) {
    throw std::runtime_error(
        name +
        ": the database does not take every byte in a text: make it with ENCODING 'SQL_ASCII' TEMPLATE template0");
  }
  if (!status.ok()) {
    const std::string said = store->message();
    fail(name + (said.empty() ? "" : ": the database server says: " + said), status);
  }
  return store;
}
#endif

}  // namespace

NamedStore NamedStore::for_reading(const std::string& name) {
  NamedStore named;
  if (is_server(name)) {
#ifdef ILP_POSTGRES
    named.server_ = connect(name, false);
    named.store_ = named.server_.get();
    return named;
#else
    throw std::runtime_error(name + ": this program was built without PostgreSQL: install libpq-dev and build again");
#endif
  }
  if (!std::filesystem::exists(name)) throw std::runtime_error(name + ": there is no such file");
  named.file_ = std::make_unique<SqliteStore>();
  const Status status = named.file_->open_read_only(name.c_str());
  if (!status.ok()) fail(name, status);
  named.store_ = named.file_.get();
  return named;
}

NamedStore NamedStore::with_tables(const std::string& name, bool& made) {
  NamedStore named;
  if (is_server(name)) {
#ifdef ILP_POSTGRES
    named.server_ = connect(name, true);
    made = named.server_->session().made_tables;
    named.store_ = named.server_.get();
    return named;
#else
    throw std::runtime_error(name + ": this program was built without PostgreSQL: install libpq-dev and build again");
#endif
  }
  made = !std::filesystem::exists(name);
  named.file_ = std::make_unique<SqliteStore>();
  const Status status = named.file_->open(name.c_str());
  if (!status.ok()) fail(name, status);
  named.store_ = named.file_.get();
  return named;
}

}  // namespace ilp::store_tool
