#include "hal/store/postgres/connection.hpp"

#include <errno.h>
#include <libpq-fe.h>
#include <poll.h>
#include <time.h>

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <new>

#include "fsw/base/heap_gate.hpp"

namespace ilp::postgres {
namespace {

constexpr std::array<int, Parameters::capacity> all_binary = [] {
  std::array<int, Parameters::capacity> ones{};
  ones.fill(1);
  return ones;
}();

void ignore_notice(void*, const char*) {}

/// Waits for the socket; false when the time is over.
bool wait_for(int socket, short events, std::int64_t milliseconds) {
  pollfd wanted{socket, events, 0};
  return milliseconds > 0 && ::poll(&wanted, 1, static_cast<int>(milliseconds)) > 0;
}

/// SQLSTATE as a number to base 36.
std::int64_t number_of(const char* state) {
  std::int64_t number = 0;
  std::from_chars(state, state + strnlen(state, 5), number, 36);
  return number;
}

bool begins(const char* text, const char* with) {
  return std::strncmp(text, with, std::strlen(with)) == 0;
}

bool any_of(const char* state, std::span<const char* const> beginnings) {
  for (const char* beginning : beginnings) {
    if (begins(state, beginning)) return true;
  }
  return false;
}

// The classes of https://www.postgresql.org/docs/15/errcodes-appendix.html
constexpr const char* connection_states[] = {"08", "57P0", "25P03", "53300"};
constexpr const char* denied_states[] = {"28", "42501", "3D000"};
constexpr const char* full_states[] = {"53100"};
constexpr const char* damaged_states[] = {"42P01", "42703", "3F000", "XX001", "XX002"};

Status status_of(const char* state, std::int64_t table) {
  if (any_of(state, connection_states)) return {StatusCode::store_lost, number_of(state)};
  if (any_of(state, denied_states)) return {StatusCode::store_denied, table};
  if (any_of(state, full_states)) return StatusCode::store_full;
  if (any_of(state, damaged_states)) return {StatusCode::store_damaged, number_of(state), table};
  return {StatusCode::store_error, number_of(state), table};
}

/// The SQLSTATE in a message of verbosity PQERRORS_VERBOSE, which begins `FATAL:  28P01: `. nullptr: it has none.
const char* state_in(const char* message) {
  // bound: the text; `at` grows
  for (const char* at = std::strstr(message, ":  "); at != nullptr; at = std::strstr(at + 1, ":  ")) {
    const char* const state = at + 3;
    std::size_t length = 0;
    while (length < 5 &&
           ((state[length] >= '0' && state[length] <= '9') || (state[length] >= 'A' && state[length] <= 'Z'))) {
      ++length;
    }
    if (length == 5 && (state[5] == ':' || state[5] == '\n')) return state;
  }
  return nullptr;
}

/// Libraries that a connection has loaded allocate once more when the process ends.
void keep_gate_open() {
  alignas(HeapGateScope) static std::byte place[sizeof(HeapGateScope)];
  new (place) HeapGateScope(HeapRegion::postgres);
}

/// Behind the libraries' own functions for the end, which the first connection registers: ours runs before them.
void expect_the_end() {
  static bool expected = false;
  if (!expected) expected = std::atexit(keep_gate_open) == 0;
}

/// Line ends become spaces.
void take_message(const char* from, FixedText<512>& to) {
  to = {};
  for (; from != nullptr && *from != 0; ++from) to.add(*from == '\n' || *from == '\t' ? ' ' : *from);
}

Status lost(Wire& wire, std::int64_t a, std::int64_t b) {
  // libpq does not always say so.
  if (a == 0 && heap_region_exhausted(HeapRegion::postgres)) b = ENOMEM;
  if (wire.connection != nullptr) take_message(PQerrorMessage(wire.connection), wire.message);
  PQfinish(wire.connection);
  wire.connection = nullptr;
  wire.sent = 0;
  return {StatusCode::store_lost, a, b};
}

/// The server, or libpq for it, has said no.
Status refused(Wire& wire) {
  take_message(PQerrorMessage(wire.connection), wire.message);
  const char* const state = state_in(PQerrorMessage(wire.connection));
  const bool no_password = PQconnectionNeedsPassword(wire.connection) != 0;
  const Status status = state != nullptr ? status_of(state, 0)
                        : no_password    ? Status{StatusCode::store_denied}
                                         : Status{StatusCode::store_lost};
  PQfinish(wire.connection);
  wire.connection = nullptr;
  return status;
}

Status start_pipeline(Wire& wire) {
  const bool ready = PQsetnonblocking(wire.connection, 1) == 0 && PQenterPipelineMode(wire.connection) == 1;
  return ready ? Status{} : lost(wire, 0, EPROTO);
}

Status connect(Wire& wire) {
  const std::int64_t end = steady_ms() + connect_limit_ms;
  PQsetErrorVerbosity(wire.connection, PQERRORS_VERBOSE);
  PQsetNoticeProcessor(wire.connection, ignore_notice, nullptr);
  PostgresPollingStatusType wanted = PGRES_POLLING_WRITING;
  while (wanted != PGRES_POLLING_OK) {  // bound: `connect_limit_ms`
    if (wanted == PGRES_POLLING_FAILED) return refused(wire);
    const short events = wanted == PGRES_POLLING_READING ? POLLIN : POLLOUT;
    if (!wait_for(PQsocket(wire.connection), events, end - steady_ms())) return lost(wire, 0, ETIMEDOUT);
    wanted = PQconnectPoll(wire.connection);
  }
  expect_the_end();
  return start_pipeline(wire);
}

Status await_result(Wire& wire) {
  const std::int64_t end = steady_ms() + answer_limit_ms;
  while (true) {  // bound: `answer_limit_ms`
    const int unsent = PQflush(wire.connection);
    if (unsent < 0) return lost(wire, 0, errno);
    if (PQisBusy(wire.connection) == 0) return {};
    const short events = unsent > 0 ? POLLIN | POLLOUT : POLLIN;
    if (!wait_for(PQsocket(wire.connection), events, end - steady_ms())) return lost(wire, 0, ETIMEDOUT);
    if (PQconsumeInput(wire.connection) == 0) return lost(wire, 0, errno);
  }
}

Status next_result(Wire& wire, PGresult*& result) {
  // Between the answers of two statements there is a null.
  result = nullptr;
  for (int attempt = 0; attempt < 3 && result == nullptr; ++attempt) {
    ILP_TRY(await_result(wire));
    result = PQgetResult(wire.connection);
  }
  return result != nullptr ? Status{} : lost(wire, 0, EPROTO);
}

Status fault_of(Wire& wire, const PGresult* result, std::int64_t table) {
  take_message(PQresultErrorMessage(result), wire.message);
  const char* const state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  if (state == nullptr || PQstatus(wire.connection) != CONNECTION_OK)
    return lost(wire, state != nullptr ? number_of(state) : 0, 0);
  const Status status = status_of(state, table);
  // The server ends the connection after such an answer.
  return status.is(StatusCode::store_lost) ? lost(wire, status.a, 0) : status;
}

FixedText<8> name_of(std::size_t statement) {
  FixedText<8> name;
  name.add('s').add(static_cast<std::int64_t>(statement));
  return name;
}

}  // namespace

std::int64_t steady_ms() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000 + now.tv_nsec / 1'000'000;
}

void Connection::finish() {
  clear();
  PQfinish(wire_.connection);
  wire_.connection = nullptr;
  prepared_.reset();
  wire_.sent = 0;
  kept_ahead_ = 0;
}

void Connection::close() {
  const HeapGateScope heap(HeapRegion::postgres);
  finish();
}

bool Connection::alive() const {
  return wire_.connection != nullptr && PQstatus(wire_.connection) == CONNECTION_OK;
}

bool Connection::texts_are_bytes() const {
  const char* const encoding =
      wire_.connection != nullptr ? PQparameterStatus(wire_.connection, "server_encoding") : nullptr;
  return encoding != nullptr && std::strcmp(encoding, "SQL_ASCII") == 0;
}

Status Connection::open(const char* conninfo) {
  const HeapGateScope heap(HeapRegion::postgres);
  finish();
  wire_.message = {};
  // Of two values of a word the later one counts, so that `conninfo` may have others than ours.
  const char* const words[] = {"keepalives_idle",  "keepalives_interval",
                               "keepalives_count", "tcp_user_timeout",
                               "application_name", "dbname",
                               "client_encoding",  nullptr};
  const char* const values[] = {"2", "1", "3", "5000", "ilp", conninfo, "SQL_ASCII", nullptr};
  wire_.connection = PQconnectStartParams(words, values, 1);
  if (wire_.connection == nullptr) return {StatusCode::arena_exhausted, 0, 0};
  if (PQstatus(wire_.connection) == CONNECTION_BAD) return refused(wire_);
  return connect(wire_);
}

Status Connection::note_sent(int accepted, const Sent& sent) {
  if (accepted == 0) return lost(wire_, 0, errno);
  queue_[wire_.sent++] = sent;
  if (sent.keep) ++kept_ahead_;
  return {};
}

Status Connection::prepare(std::size_t statement, const char* sql, std::int64_t table) {
  const HeapGateScope heap(HeapRegion::postgres);
  if (!alive()) return StatusCode::store_lost;
  ILP_ASSERT(wire_.sent < max_sent, wire_.sent);
  prepared_[statement] = true;
  return note_sent(PQsendPrepare(wire_.connection, name_of(statement).c_str(), sql, 0, nullptr),
                   {table, statement, false, false});
}

Status Connection::send(std::size_t statement, const Parameters& parameters, std::int64_t table, bool keep) {
  const HeapGateScope heap(HeapRegion::postgres);
  if (!alive()) return StatusCode::store_lost;
  ILP_ASSERT(!parameters.overflow() && wire_.sent < max_sent, wire_.sent);
  const int accepted = PQsendQueryPrepared(wire_.connection, name_of(statement).c_str(), parameters.count(),
                                           parameters.values(), parameters.lengths(), all_binary.data(), 1);
  return note_sent(accepted, {table, max_statements, keep, false});
}

Status Connection::send(const char* sql, bool keep) {
  const HeapGateScope heap(HeapRegion::postgres);
  if (!alive()) return StatusCode::store_lost;
  ILP_ASSERT(wire_.sent < max_sent, wire_.sent);
  const int accepted = PQsendQueryParams(wire_.connection, sql, 0, nullptr, nullptr, nullptr, nullptr, 1);
  return note_sent(accepted, {0, max_statements, keep, false});
}

/// Takes the answer of one statement. `aborted`: an earlier one has failed.
Status Connection::answer(const Sent& sent, bool aborted) {
  PGresult* result = nullptr;
  ILP_TRY(next_result(wire_, result));
  const ExecStatusType kind = PQresultStatus(result);
  if (sent.is_push || kind == PGRES_PIPELINE_SYNC) {
    PQclear(result);
    return sent.is_push && kind == PGRES_PIPELINE_SYNC ? Status{} : lost(wire_, 0, EPROTO);
  }
  const bool good = kind == PGRES_COMMAND_OK || kind == PGRES_TUPLES_OK;
  if (good && sent.prepares == max_statements) {
    rows_changed_ = 0;
    const char* const changed = PQcmdTuples(result);
    std::from_chars(changed, changed + std::strlen(changed), rows_changed_);
  }
  if (good && sent.keep && held_ < kept_.size()) {
    kept_[held_++].hold(result);
    return {};
  }
  if (!good && sent.prepares != max_statements) prepared_[sent.prepares] = false;
  const Status status =
      good || (aborted && kind == PGRES_PIPELINE_ABORTED) ? Status{} : fault_of(wire_, result, sent.table);
  PQclear(result);
  return status;
}

Status Connection::push_sent() {
  if (!alive()) return StatusCode::store_lost;
  ILP_ASSERT(wire_.sent < max_sent, wire_.sent);
  ILP_TRY(note_sent(PQpipelineSync(wire_.connection), {0, max_statements, false, true}));
  return PQflush(wire_.connection) < 0 ? lost(wire_, 0, errno) : Status{};
}

Status Connection::push() {
  const HeapGateScope heap(HeapRegion::postgres);
  return push_sent();
}

Status Connection::collect() {
  const HeapGateScope heap(HeapRegion::postgres);
  clear();
  kept_ahead_ = 0;
  ILP_TRY(push_sent());
  Status first;
  bool aborted = false;
  const std::size_t count = wire_.sent;
  for (std::size_t i = 0; i < count; ++i) {
    const Status status = answer(queue_[i], aborted);
    if (wire_.connection == nullptr) return status;
    if (first.ok()) first = status;
    aborted = !queue_[i].is_push && (aborted || !status.ok());
  }
  wire_.sent = 0;
  return first;
}

void Connection::clear() {
  for (Rows& rows : kept_) rows.clear();
  held_ = 0;
}

Status Connection::receive() {
  const HeapGateScope heap(HeapRegion::postgres);
  if (!alive()) return StatusCode::store_lost;
  return PQconsumeInput(wire_.connection) != 0 ? Status{} : lost(wire_, 0, errno);
}

bool Connection::next_notification(Notification& notification) {
  const HeapGateScope heap(HeapRegion::postgres);
  PGnotify* const note = wire_.connection != nullptr ? PQnotifies(wire_.connection) : nullptr;
  if (note == nullptr) return false;
  notification = {};
  notification.own = note->be_pid == PQbackendPID(wire_.connection);
  const char* const end = note->extra + std::strlen(note->extra);
  const char* const rest = std::from_chars(note->extra, end, notification.commit).ptr;
  if (rest < end) std::from_chars(rest + 1, end, notification.tables);
  PQfreemem(note);
  return true;
}

void Connection::wait(std::int64_t milliseconds) const {
  if (wire_.connection != nullptr) static_cast<void>(wait_for(PQsocket(wire_.connection), POLLIN, milliseconds));
}

}  // namespace ilp::postgres

bool ilp::holds_password(const char* conninfo) {
  const HeapGateScope heap(HeapRegion::postgres);
  PQconninfoOption* const words = PQconninfoParse(conninfo, nullptr);
  bool found = false;
  for (const PQconninfoOption* word = words; word != nullptr && word->keyword != nullptr; ++word) {
    const bool secret = std::strcmp(word->keyword, "password") == 0 || std::strcmp(word->keyword, "sslpassword") == 0;
    found = found || (secret && word->val != nullptr);
  }
  PQconninfoFree(words);
  return found;
}
