// What a process knows of a store on a server and has yet to send to it. The functions without a description are those
// of PostgresStore.
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
  bool create = true;       ///< false: a database without tables is `not_found`
  bool notify = true;       ///< false: other processes find changes only by looking for them (tests)
  bool synchronous = true;  ///< false: a server that loses power may lose the latest commits
};

/// Changes of other processes are looked for after this time even without a notification.
inline constexpr std::int64_t postgres_poll_ms = 1000;
/// A file for the ground or the state of a component. A larger blob is refused with `capacity_exceeded`.
inline constexpr std::size_t max_postgres_blob_bytes = std::max(
    (limits::max_transfer_bytes + blob_chunk_bytes - 1) / blob_chunk_bytes * blob_chunk_bytes, std::size_t{1} << 20U);

}  // namespace ilp

namespace ilp::postgres {

inline constexpr std::size_t record_count = static_cast<std::size_t>(RecordType::count);
inline constexpr std::size_t no_place = ~std::size_t{0};

/// Answers that the next collect() brings.
struct Awaited {
  std::size_t look = no_place, answer = no_place, change = no_place;
};

/// The record that this transaction has put last: the server has yet to get the sizes of its blobs.
struct LatestPut {
  const RecordInfo* info = nullptr;
  std::int64_t id = 0;
  std::array<std::uint32_t, max_blob_fields> bytes{};
  std::array<bool, max_blob_fields> sent{};
};

struct OpenTransaction {
  bool open = false;
  bool started = false;  ///< the server knows of the transaction
  Status doomed;         ///< the fault that made a commit of this transaction impossible
  RecordMask uncommitted = 0;
  RecordMask touched = 0;  ///< also by writes that failed
  LatestPut latest;
};

/// A blob whose bytes are here.
struct HeldBlob {
  BlobName name;           ///< type `count`: none
  bool changed = false;    ///< the server has yet to get it: true for one of them at most, the latest one
  std::uint64_t used = 0;  ///< larger: used later
  std::array<std::uint8_t, 4 * (max_postgres_blob_bytes / blob_chunk_bytes)> sums;  ///< as they are stored
  std::array<std::uint8_t, max_postgres_blob_bytes> bytes;

  void forget() {
    name = {};
    changed = false;
  }
};
struct HeldBlobs {
  /// Enough for an image and a depth map with its errors, while others are written.
  std::array<HeldBlob, 6> places;
  HeldBlob* latest = places.data();
  std::uint64_t uses = 0;
};

/// Of tables, by this process and others.
struct Changes {
  RecordMask changed = 0;                            ///< since the latest poll()
  RecordMask unread = 0;                             ///< changed by the look that came with an answer
  std::array<std::int64_t, record_count> numbers{};  ///< commit that changed the table last, as far as it is known
  std::int64_t received = 0;                         ///< all commits up to this one are known
  bool received_others = true;                       ///< since the latest flush()
  bool poll_now = false;
  std::int64_t polled_ms = 0;
};

struct Capacity {
  std::int64_t limit_bytes = 0;  ///< 0: no limit
  std::int64_t used_bytes = 0;
  std::int64_t asked_bytes = 0;  ///< of blobs put since used_bytes was read
  bool used_is_known = false;
  std::int64_t used_ms = -postgres_poll_ms;  ///< when it was read
};

struct Session {
  Connection connection;
  Connection flusher;  ///< of flush(), from its first call on
  FixedText<max_conninfo_bytes> conninfo;
  RecordMask watched = 0;
  PostgresOptions options;
  StageMask claimed = 0;
  bool made_tables = false;  ///< by open()

  OpenTransaction transaction;
  Awaited awaited;
  AnswerCache answers;
  std::array<std::int64_t, record_count> walked_to{};  ///< id that the latest next() has returned
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

Status connect(Session& s);
/// Sends the beginning of the transaction, if that is still to be done.
Status start(Session& s);
/// The queue of statements without an answer is finite.
Status make_room(Session& s);
Status send(Session& s, RowVerb verb, const RecordInfo& info, const Parameters& parameters, bool keep);
Status send(Session& s, BlobVerb verb, const RecordInfo& info, std::size_t blob, const Parameters& parameters,
            bool keep);
Status send_special(Session& s, std::size_t which, void (*text)(SqlText&), const Parameters& parameters);
Status send_look(Session& s);
Status collect(Session& s);
/// Collects the answer to the statement that was sent last.
Status collect_answer(Session& s);
Status writable(Session& s);
Status written(Session& s, const RecordInfo& info, Status status);

Status read_used_bytes(Session& s, std::int64_t& bytes);
/// Of all blobs of a record, as they are on the server.
Status read_blob_sizes(Session& s, const RecordInfo& info, std::int64_t id, std::int64_t& bytes);

[[nodiscard]] HeldBlob* find_held(Session& s, const BlobName& blob);
void drop_held(Session& s, RecordMask tables);
void drop_held_of(Session& s, RecordType type, std::int64_t id);
/// Sends the sizes of the blobs of the latest put that were not written whole since.
Status send_latest_sizes(Session& s);
Status send_held_blob(Session& s);

/// Compares the numbers of commits with those that are known.
Status take_look(Session& s);
/// The number of our own commit. What is known of its tables is known as they are now.
void take_change(Session& s);
void take_notifications(Session& s);
Status look(Session& s);

}  // namespace ilp::postgres
