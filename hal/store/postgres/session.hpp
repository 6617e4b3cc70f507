// State of a process's connection to a store on a server, and the functions of PostgresStore on it. Functions without a
// description are those of PostgresStore with the same name.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "fsw/base/result.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/postgres/answer_cache.hpp"
#include "hal/store/postgres/connection.hpp"
#include "hal/store/postgres/sql_text.hpp"
#include "hal/store/record_bytes.hpp"
#include "hal/store/store.hpp"
#include "hal/store/store_sharing.hpp"

namespace ilp {

struct PostgresOptions {
  bool create = true;       ///< open() makes missing tables; false: it returns `not_found`
  bool notify = true;       ///< commits notify other processes; false: these find changes only by polling (tests)
  bool synchronous = true;  ///< commit() waits for the server's disk; false: a power cut may undo the latest commits
};

/// Interval at which a process polls for changes of others, even without a notification.
inline constexpr std::int64_t postgres_poll_ms = 1000;
/// Limit of a blob: the size of the largest file for the ground or state of a component. A put of a larger blob returns
/// `capacity_exceeded`.
inline constexpr std::size_t max_postgres_blob_bytes = std::max(
    (limits::max_transfer_bytes + blob_chunk_bytes - 1) / blob_chunk_bytes * blob_chunk_bytes, std::size_t{1} << 20U);

}  // namespace ilp

namespace ilp::postgres {

inline constexpr std::size_t record_count = static_cast<std::size_t>(RecordType::count);
inline constexpr std::size_t no_place = ~std::size_t{0};

/// Indexes for Connection::rows() of answers that the next collect() brings: to look_at_changes(), to a read, and to
/// note_changes().
struct Awaited {
  std::size_t look = no_place, answer = no_place, change = no_place;
};

/// The record that this transaction has put last. Its blobs' sizes are sent later, unless the blobs are written first.
struct LatestPut {
  const RecordInfo* info = nullptr;
  std::int64_t id = 0;
  std::array<std::uint32_t, max_blob_fields> bytes{};  ///< sizes of the blobs
  std::array<bool, max_blob_fields> sent{};            ///< the server has the size
};

struct OpenTransaction {
  bool open = false;
  bool started = false;        ///< the server knows of the transaction
  Status doomed;               ///< fault that makes a commit of this transaction impossible
  RecordMask uncommitted = 0;  ///< tables that the transaction has changed
  RecordMask touched = 0;      ///< tables that it has changed or tried to change
  LatestPut latest;
};

/// A blob that this process keeps in memory.
struct HeldBlob {
  BlobName name;           ///< type `count`: none
  bool changed = false;    ///< the server does not have its bytes yet; only HeldBlobs::latest may be so
  std::uint64_t used = 0;  ///< value of HeldBlobs::uses at the latest use
  std::array<std::uint8_t, 4 * (max_postgres_blob_bytes / blob_chunk_bytes)> sums;  ///< checksums of the chunks
  std::array<std::uint8_t, max_postgres_blob_bytes> bytes;

  void forget() {
    name = {};
    changed = false;
  }
};
struct HeldBlobs {
  /// Their number suffices for an image and a depth map with its errors while other blobs are written.
  std::array<HeldBlob, 6> places;
  HeldBlob* latest = places.data();
  std::uint64_t uses = 0;
};

/// What is known of changes of tables by this process and others. The server numbers commits.
struct Changes {
  RecordMask changed = 0;                            ///< tables changed since the latest poll()
  RecordMask unread = 0;                             ///< tables whose change came with the answer to another question
  std::array<std::int64_t, record_count> numbers{};  ///< latest known commit that changed each table
  std::int64_t received = 0;                         ///< all commits up to this number are known
  bool received_others = true;                       ///< another process has committed since the latest flush()
  bool poll_now = false;                             ///< a notification was missed
  std::int64_t polled_ms = 0;                        ///< when the numbers were last read (steady_ms)
};

/// State of PostgresStore::limit() and usage().
struct Capacity {
  std::int64_t limit_bytes = 0;              ///< 0: no limit
  std::int64_t used_bytes = 0;               ///< as the server has last reported
  std::int64_t asked_bytes = 0;              ///< bytes of blobs put since `used_bytes` was read
  bool used_is_known = false;                ///< nothing has changed since `used_bytes` was read
  std::int64_t used_ms = -postgres_poll_ms;  ///< when `used_bytes` was read (steady_ms)
};

struct Session {
  Connection connection;
  Connection flusher;  ///< second connection, for flush()
  FixedText<max_conninfo_bytes> conninfo;
  RecordMask watched = 0;
  PostgresOptions options;
  StageMask claimed = 0;
  bool made_tables = false;  ///< open() has made the tables

  OpenTransaction transaction;
  Awaited awaited;
  AnswerCache answers;
  std::array<std::int64_t, record_count> walked_to{};  ///< for each table, id that the latest next() has returned
  HeldBlobs blobs;
  Changes changes;
  Capacity capacity;
};

Status open(Session& s, const char* conninfo, RecordMask watched, PostgresOptions options);
void close(Session& s);
Status begin(Session& s);
Status commit(Session& s);
void rollback(Session& s);
Status put(Session& s, const RecordInfo& info, const void* record);
Status get(Session& s, const RecordInfo& info, std::int64_t id, void* record);
Status next(Session& s, const RecordInfo& info, std::int64_t after, void* record);
Status last(Session& s, const RecordInfo& info, void* record);
Status erase(Session& s, const RecordInfo& info, std::int64_t id);
Status count(Session& s, const RecordInfo& info, std::int64_t& records);
Status write_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                  std::span<const std::uint8_t> bytes);
Status read_blob(Session& s, const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                 std::span<std::uint8_t> bytes);
Status poll(Session& s, RecordMask& changed);
StoreUsage usage(Session& s);
Status claim(Session& s, StageMask stages);
void release(Session& s);
Status reconnect(Session& s);
Status flush(Session& s);
void wait(Session& s, std::int32_t milliseconds);

/// Connects, checks the tables and drops everything that was cached.
Status connect(Session& s);
/// Sends the beginning of the transaction, if the server does not know of it yet.
Status start(Session& s);
/// Collects answers if the queue of statements is full.
Status make_room(Session& s);
Status send(Session& s, RowVerb verb, const RecordInfo& info, const Parameters& parameters, bool keep);
Status send(Session& s, BlobVerb verb, const RecordInfo& info, std::size_t blob, const Parameters& parameters,
            bool keep);
/// Sends a statement that belongs to no table; text() writes its SQL. `which` is its number.
Status send_special(Session& s, std::size_t which, void (*text)(SqlText&), const Parameters& parameters);
/// Sends look_at_changes().
Status send_look(Session& s);
/// Connection::collect(); also evaluates the awaited answers about changes.
Status collect(Session& s);
/// Collects the answer to the statement that was sent last.
Status collect_answer(Session& s);
/// Returns `invalid_argument` outside a transaction, and the fault of an earlier write of the transaction.
Status writable(Session& s);
/// Notes the result of a write; an error dooms the transaction.
Status written(Session& s, const RecordInfo& info, Status status);

/// Asks the server for used_bytes().
Status read_used_bytes(Session& s, std::int64_t& bytes);
/// Asks the server for the total size of a record's blobs.
Status read_blob_sizes(Session& s, const RecordInfo& info, std::int64_t id, std::int64_t& bytes);

/// Finds a blob in memory; nullptr: it is not there. The size in `blob` is ignored.
[[nodiscard]] HeldBlob* find_held(Session& s, const BlobName& blob);
/// Drop the blobs in memory of these tables, or of one record.
void drop_held(Session& s, RecordMask tables);
void drop_held_of(Session& s, RecordType type, std::int64_t id);
/// Sends the sizes of those blobs of the latest put that were not written completely since.
Status send_latest_sizes(Session& s);
/// Sends the latest blob in memory if the server does not have its bytes.
Status send_held_blob(Session& s);

/// Evaluates an answer to look_at_changes(): finds the tables that others have changed.
Status take_look(Session& s);
/// Evaluates the number of this process's own commit. Cached data of its tables stay valid.
void take_change(Session& s);
/// Evaluates the notifications that have arrived.
void take_notifications(Session& s);
/// Asks for changes and evaluates the answer.
Status look(Session& s);

}  // namespace ilp::postgres
