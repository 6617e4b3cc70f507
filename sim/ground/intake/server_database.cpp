#include <stdexcept>

#include "sim/ground/intake/catalogue_database.hpp"

#ifdef ILP_POSTGRES
#include <libpq-fe.h>

#include <array>
#include <deque>
#include <optional>
#include <utility>
#endif

namespace ilp::intake {
#ifdef ILP_POSTGRES
namespace {

constexpr int server_version = 1;

// Names and faults are octets: what came down may be no text. Their order is then that of SQLite too.
constexpr const char* server_schema =
    "CREATE SCHEMA IF NOT EXISTS aerobot_catalogue; SET search_path TO aerobot_catalogue;"
    "CREATE TABLE IF NOT EXISTS mission(mission text PRIMARY KEY, version bigint, mark bigint);"
    "CREATE TABLE IF NOT EXISTS seen(mission text, name bytea, bytes bigint, modified bigint, fault bytea, "
    "PRIMARY KEY(mission, name));"
    "CREATE TABLE IF NOT EXISTS file(mission text, rowid bigserial, name bytea, crc32 bigint, bytes bigint, "
    "fault bytea, contents bytea, PRIMARY KEY(mission, name, crc32));"
    "CREATE TABLE IF NOT EXISTS look(mission text, keyframe bigint, digest bigint, bytes bytea, "
    "PRIMARY KEY(mission, keyframe));"
    "CREATE TABLE IF NOT EXISTS result(mission text, digest bigint, crc32 bigint, bytes bytea, "
    "PRIMARY KEY(mission, digest));"
    "CREATE TABLE IF NOT EXISTS tile(mission text, strip bigint, \"row\" bigint, \"column\" bigint, digest bigint, "
    "summary bytea, cells bytea, PRIMARY KEY(mission, strip, \"row\", \"column\"));"
    "CREATE TABLE IF NOT EXISTS finished_tile(mission text, strip bigint, \"row\" bigint, \"column\" bigint, "
    "digest bigint, summary bytea, cells bytea, PRIMARY KEY(mission, strip, \"row\", \"column\"));"
    // What is packed already is not packed again.
    "ALTER TABLE file ALTER contents SET STORAGE EXTERNAL; ALTER TABLE tile ALTER cells SET STORAGE EXTERNAL;"
    "ALTER TABLE finished_tile ALTER cells SET STORAGE EXTERNAL; ALTER TABLE result ALTER bytes SET STORAGE EXTERNAL;";

struct Closer {
  void operator()(PGconn* connection) const { PQfinish(connection); }
  void operator()(PGresult* result) const { PQclear(result); }
};
using Result = std::unique_ptr<PGresult, Closer>;

[[noreturn]] void fail(PGconn* connection) {
  throw std::runtime_error(std::string("the shared catalogue: ") + PQerrorMessage(connection));
}

/// Numbers parameters as the server wants them: $1, $2, ...
std::string numbered(const std::string& sql) {
  std::string text;
  int number = 0;
  for (const char c : sql) text += c == '?' ? "$" + std::to_string(++number) : std::string(1, c);
  return text;
}

class ServerStatement final : public Statement {
 public:
  ServerStatement(PGconn* connection, std::string sql, bool large)
      : connection_(connection), sql_(std::move(sql)), large_(large) {}
  ~ServerStatement() override {
    while (sent_ && !ended_) next();
  }
  ServerStatement(const ServerStatement&) = delete;
  ServerStatement& operator=(const ServerStatement&) = delete;

  Statement& bind(std::int64_t value) override {
    return add(owned_.emplace_back(std::to_string(value)), oid_integer, 0);
  }
  Statement& bind(const std::string& text) override { return add(owned_.emplace_back(text), oid_octets, 1); }
  Statement& bind(std::span<const std::uint8_t> bytes) override {
    // An empty value has an address too: none would be NULL.
    values_.push_back(bytes.empty() ? "" : reinterpret_cast<const char*>(bytes.data()));
    return described(bytes.size(), oid_octets, 1);
  }

  bool step() override {
    if (!sent_) send();
    while (!ended_ && ++row_ >= PQntuples(result_.get())) next();
    return !ended_;
  }
  std::int64_t integer(int column) override {
    const auto octets = octets_of(column);
    std::uint64_t value = !octets.empty() && (octets[0] & 0x80U) != 0 ? ~std::uint64_t{0} : 0;
    for (const std::uint8_t octet : octets) value = value << 8U | octet;
    return static_cast<std::int64_t>(value);
  }
  std::vector<std::uint8_t> bytes(int column) override {
    const auto octets = octets_of(column);
    return {octets.begin(), octets.end()};
  }

 private:
  static constexpr Oid oid_integer = 20, oid_octets = 17;

  Statement& add(const std::string& value, Oid type, int format) {
    values_.push_back(value.data());
    return described(value.size(), type, format);
  }
  Statement& described(std::size_t bytes, Oid type, int format) {
    sizes_.push_back(static_cast<int>(bytes));
    types_.push_back(type);
    formats_.push_back(format);
    return *this;
  }
  [[nodiscard]] std::span<const std::uint8_t> octets_of(int column) const {
    return {reinterpret_cast<const std::uint8_t*>(PQgetvalue(result_.get(), row_, column)),
            static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
  }
  void send() {
    if (PQsendQueryParams(connection_, sql_.c_str(), static_cast<int>(values_.size()), types_.data(), values_.data(),
                          sizes_.data(), formats_.data(), 1) == 0) {
      fail(connection_);
    }
    sent_ = true;
    if (large_) PQsetSingleRowMode(connection_);
    next();
    if (!large_) take_end();
  }
  /// The next result of the server: one row of a large statement, else all of them.
  void next() {
    if (whole_) {
      ended_ = true;
      return;
    }
    result_.reset(PQgetResult(connection_));
    row_ = -1;
    ended_ = result_ == nullptr;
    if (ended_) return;
    const ExecStatusType status = PQresultStatus(result_.get());
    if (status == PGRES_TUPLES_OK || status == PGRES_COMMAND_OK || status == PGRES_SINGLE_TUPLE) return;
    const std::string message = PQresultErrorMessage(result_.get());
    while (const Result rest{PQgetResult(connection_)}) {
    }
    ended_ = true;
    throw std::runtime_error("the shared catalogue: " + message);
  }
  /// The connection is free for the next statement then.
  void take_end() {
    while (const Result rest{PQgetResult(connection_)}) {
    }
    whole_ = true;
  }

  PGconn* connection_;
  std::string sql_;
  bool large_, sent_ = false, whole_ = false, ended_ = false;
  std::deque<std::string> owned_;
  std::vector<const char*> values_;
  std::vector<int> sizes_, formats_;
  std::vector<Oid> types_;
  Result result_;
  int row_ = -1;
};

class ServerDatabase final : public CatalogueDatabase {
 public:
  ServerDatabase(const std::string& address, const std::string& mission) : connection_(PQconnectdb(address.c_str())) {
    if (PQstatus(connection_.get()) != CONNECTION_OK) fail(connection_.get());
    PQsetNoticeProcessor(
        connection_.get(), [](void*, const char*) {}, nullptr);
    char* literal = PQescapeLiteral(connection_.get(), mission.data(), mission.size());
    if (literal == nullptr) fail(connection_.get());
    mission_ = literal;
    PQfreemem(literal);
    // A power cut may cost the last steps, never the rest: they are computed again.
    exec("SET synchronous_commit TO off; SET lock_timeout TO '10s'");
    create();
    exec("SELECT pg_advisory_lock(hashtextextended('aerobot catalogue ' || " + mission_ + ", 0))");
    start();
  }

  std::unique_ptr<Statement> prepare(const std::string& sql, bool large = false) override {
    return std::make_unique<ServerStatement>(
        connection_.get(), numbered(with_mission(sql, "mission = " + mission_ + " AND ", "mission, ", mission_ + ", ")),
        large);
  }
  void begin() override { exec("BEGIN"); }
  void commit() override { exec("COMMIT"); }
  void roll_back() noexcept override { const Result ignored(PQexec(connection_.get(), "ROLLBACK")); }

  std::uint64_t mark() override { return mark_; }
  void keep_mark(std::uint64_t mark) override {
    prepare("UPDATE mission SET mark = ? WHERE {and}1 = 1")->bind(static_cast<std::int64_t>(mark)).run();
  }

 private:
  void exec(const std::string& sql) {
    const Result result(PQexec(connection_.get(), sql.c_str()));
    const ExecStatusType status = PQresultStatus(result.get());
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) fail(connection_.get());
  }
  /// Missions that begin at the same time must not create the same tables.
  void create() {
    exec("BEGIN; SELECT pg_advisory_xact_lock(hashtext('aerobot catalogue tables'))");
    const auto there = prepare("SELECT 1 WHERE to_regclass('aerobot_catalogue.finished_tile') IS NOT NULL");
    exec(there->step() ? "SET search_path TO aerobot_catalogue" : server_schema);
    exec("COMMIT");
  }
  /// From now on nobody may take the results of an earlier run for those of the tables.
  void start() {
    prepare("INSERT INTO mission(mission, version, mark) VALUES({value}?, 0) ON CONFLICT DO NOTHING")
        ->bind(std::int64_t{server_version})
        .run();
    const auto row = prepare("SELECT version, mark FROM mission WHERE {and}1 = 1");
    if (!row->step() || row->integer(0) != server_version) {
      throw std::runtime_error(
          "the shared catalogue holds the mission as another version of ilp-ground has written it");
    }
    mark_ = static_cast<std::uint64_t>(row->integer(1));
  }

  std::unique_ptr<PGconn, Closer> connection_;
  std::string mission_;  ///< as a literal of SQL
  std::uint64_t mark_ = 0;
};

}  // namespace

std::unique_ptr<CatalogueDatabase> open_catalogue_server(const std::string& address, const std::string& mission) {
  return std::make_unique<ServerDatabase>(address, mission);
}
#else
std::unique_ptr<CatalogueDatabase> open_catalogue_server(const std::string&, const std::string&) {
  throw std::runtime_error("this build knows no PostgreSQL: libpq-dev was not installed (bsp/install-packages test)");
}
#endif

}  // namespace ilp::intake
