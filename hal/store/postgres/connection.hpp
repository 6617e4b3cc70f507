// A connection to the server in libpq's pipeline mode: statements are sent without waiting, and their answers are
// collected together in one round trip.
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

/// Whether a connection string contains a password. It must not on a command line, because other users can read that.
[[nodiscard]] bool holds_password(const char* conninfo);

}  // namespace ilp

namespace ilp::postgres {

/// Longest time without an answer; after it the connection is lost. The server answers earlier if a transaction waits
/// for that of another process (`lock_timeout`).
inline constexpr std::int64_t answer_limit_ms = 20'000;
inline constexpr std::int64_t connect_limit_ms = 5'000;
inline constexpr std::size_t max_conninfo_bytes = 1024;

/// The announcement of a commit that has changed tables.
struct Notification {
  std::int64_t commit = 0;  ///< number of the commit
  std::int64_t tables = 0;  ///< RecordMask of the changed tables
  bool own = false;         ///< the commit is one of this process
};

/// State of a connection of libpq.
struct Wire {
  pg_conn* connection = nullptr;
  std::size_t sent = 0;    ///< statements whose answers were not collected
  FixedText<512> message;  ///< why the latest call failed
};

/// The functions return `store_lost` if the connection fails (first value: SQLSTATE or 0, second: errno or 0), and then
/// in every call until open(). They return `store_denied` if access is refused (first value: RecordType), `store_full`
/// if the server's disk is full, `store_damaged` if a table is missing or damaged (first value: SQLSTATE, second:
/// RecordType), and `store_error` for other errors (first value: SQLSTATE, second: RecordType). An SQLSTATE is given as
/// a number to base 36. A RecordType of 0 may also mean that no table is concerned.
class Connection {
 public:
  ~Connection() { close(); }

  /// Connects to the server within connect_limit_ms. `conninfo` is a connection string of libpq, which may override the
  /// keep-alive settings of this class.
  Status open(const char* conninfo);
  void close();
  [[nodiscard]] bool alive() const;
  /// Whether the server's encoding is SQL_ASCII, so that texts may have any bytes.
  [[nodiscard]] bool texts_are_bytes() const;
  /// Sentence that says why the latest call failed. It contains no password.
  [[nodiscard]] const char* message() const { return wire_.message.c_str(); }

  static constexpr std::size_t max_statements = 1024;
  /// Whether statement number `statement` was prepared.
  [[nodiscard]] bool prepared(std::size_t statement) const { return prepared_[statement]; }
  /// Sends a statement to be prepared under a number. `table` is the RecordType for a status.
  Status prepare(std::size_t statement, const char* sql, std::int64_t table);
  /// Sends a prepared statement, or a text. With `keep`, collect() stores the answer in rows(next_place()).
  Status send(std::size_t statement, const Parameters& parameters, std::int64_t table, bool keep);
  Status send(const char* sql, bool keep);
  /// Index for rows() of the next answer that is kept.
  [[nodiscard]] std::size_t next_place() const { return kept_ahead_; }
  /// Sends a synchronisation point without waiting. After an error the server skips the statements up to the next such
  /// point.
  Status push();
  /// Sends a synchronisation point and waits for the answers of all statements since the latest collect(). Returns the
  /// first error.
  Status collect();
  /// A kept answer, in the order of sending.
  [[nodiscard]] const Rows& rows(std::size_t place) const { return kept_[place]; }
  /// Drops the kept answers.
  void clear();
  /// After collect(): rows that the latest statement has changed or returned.
  [[nodiscard]] std::int64_t rows_changed() const { return rows_changed_; }
  /// Whether there are statements whose answers were not collected.
  [[nodiscard]] bool anything_sent() const { return wire_.sent != 0; }
  /// Whether collect() must be called before more statements are sent.
  [[nodiscard]] bool is_full() const { return wire_.sent + 24 > max_sent; }

  /// Takes the next notification that receive() has read. Returns false if there is none.
  bool next_notification(Notification& notification);
  /// Reads from the socket without waiting.
  Status receive();
  /// Waits until something can be read, at most `milliseconds`.
  void wait(std::int64_t milliseconds) const;

 private:
  static constexpr std::size_t max_sent = 256;
  struct Sent {
    std::int64_t table = 0;
    std::size_t prepares = max_statements;  ///< number of the statement that is prepared; max_statements: none
    bool keep = false;
    bool is_push = false;  ///< a synchronisation point
  };

  void finish();
  Status push_sent();
  Status answer(const Sent& sent, bool aborted);
  Status note_sent(int accepted, const Sent& sent);

  Wire wire_;
  std::bitset<max_statements> prepared_;
  std::array<Sent, max_sent> queue_{};
  std::array<Rows, 8> kept_;
  std::size_t held_ = 0;        ///< answers in `kept_`
  std::size_t kept_ahead_ = 0;  ///< answers that the next collect() will keep
  std::int64_t rows_changed_ = 0;
};

/// Milliseconds of the board's monotonic clock.
[[nodiscard]] std::int64_t steady_ms();

}  // namespace ilp::postgres
