// A connection to the server. Statements are sent ahead; their answers are collected together, in one round trip.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"
#include "fsw/base/text.hpp"
#include "hal/store/postgres/parameters.hpp"
#include "hal/store/postgres/rows.hpp"

struct pg_conn;
struct pg_result;

namespace ilp {

/// Whether the text names a password, which does not belong on a command line: other users can read it there.
[[nodiscard]] bool holds_password(const char* conninfo);

}  // namespace ilp

namespace ilp::postgres {

/// After this time without an answer the connection counts as lost. A transaction that waits for another process's is
/// answered sooner (`lock_timeout`).
inline constexpr std::int64_t answer_limit_ms = 20'000;
inline constexpr std::int64_t connect_limit_ms = 5'000;
inline constexpr std::size_t max_conninfo_bytes = 1024;

/// What another process has announced.
struct Notification {
  std::int64_t commit = 0;
  std::int64_t tables = 0;  ///< a RecordMask
  bool own = false;         ///< this process has announced it
};

/// What libpq has of a connection.
struct Wire {
  pg_conn* connection = nullptr;
  std::size_t sent = 0;    ///< statements whose answer was not taken
  FixedText<512> message;  ///< why the latest call failed
};

/// Statuses: `store_lost` for a fault of the connection (a = a number of the server, b = 0; or a = 0, b = errno or 0);
/// `store_denied` (a = number of the table, 0: none); `store_full` without room on the server's disk; `store_damaged`
/// when a table or its content is not as it should be; `store_error` otherwise (a = SQLSTATE as a number to base 36, b
/// = number of the table). After store_lost every call fails until open().
class Connection {
 public:
  ~Connection() { close(); }

  /// `conninfo` as libpq takes it; keep-alives that it does not set are ours.
  Status open(const char* conninfo);
  void close();
  [[nodiscard]] bool alive() const;
  [[nodiscard]] bool texts_are_bytes() const;
  /// Says in a sentence why the latest call failed. It holds no password.
  [[nodiscard]] const char* message() const { return wire_.message.c_str(); }

  static constexpr std::size_t max_statements = 1024;
  [[nodiscard]] bool prepared(std::size_t statement) const { return prepared_[statement]; }
  Status prepare(std::size_t statement, const char* sql, std::int64_t table);
  /// `keep`: collect() puts the answer into rows(0), rows(1), ... in the order of sending.
  Status send(std::size_t statement, const Parameters& parameters, std::int64_t table, bool keep);
  Status send(const char* sql, bool keep);
  /// The place of the next answer that is kept.
  [[nodiscard]] std::size_t next_place() const { return kept_ahead_; }
  /// Lets the server carry out what was sent without waiting for it. A fault stops what was sent before this call, not
  /// what is sent behind it.
  Status push();
  /// Takes the answers of all statements that were sent since the latest collect(). The first fault is returned; the
  /// server has carried out nothing between it and the next push().
  Status collect();
  [[nodiscard]] const Rows& rows(std::size_t place) const { return kept_[place]; }
  void clear();
  /// Of the latest statement, after collect().
  [[nodiscard]] std::int64_t rows_changed() const { return rows_changed_; }
  [[nodiscard]] bool anything_sent() const { return wire_.sent != 0; }
  [[nodiscard]] bool is_full() const { return wire_.sent + 24 > max_sent; }

  /// False when there is none. Reads from the socket and never waits.
  bool next_notification(Notification& notification);
  Status receive();
  /// Until something can be read, and for this long at most.
  void wait(std::int64_t milliseconds) const;

 private:
  static constexpr std::size_t max_sent = 256;
  struct Sent {
    std::int64_t table = 0;
    std::size_t prepares = max_statements;  ///< statement, if this prepares one
    bool keep = false;
    bool is_push = false;
  };

  void finish();
  Status push_sent();
  Status answer(const Sent& sent, bool aborted);
  Status note_sent(int accepted, const Sent& sent);

  Wire wire_;
  std::bitset<max_statements> prepared_;
  std::array<Sent, max_sent> queue_{};
  std::array<Rows, 8> kept_;
  std::size_t held_ = 0;
  std::size_t kept_ahead_ = 0;  ///< answers that the next collect() keeps
  std::int64_t rows_changed_ = 0;
};

/// Milliseconds of a clock that never goes back.
[[nodiscard]] std::int64_t steady_ms();

}  // namespace ilp::postgres
