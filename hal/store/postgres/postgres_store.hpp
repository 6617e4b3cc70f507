// The store on a PostgreSQL server, which several processes on one or several machines share (docs/store.md).
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "fsw/base/result.hpp"
#include "hal/store/checksums.hpp"
#include "hal/store/postgres/answer_cache.hpp"
#include "hal/store/postgres/connection.hpp"
#include "hal/store/postgres/early_reads.hpp"
#include "hal/store/postgres/guesses.hpp"
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
inline constexpr std::int64_t postgres_look_ms = 1000;
/// SQLSTATE 40001, serialization failure, as a number to base 36.
inline constexpr std::int64_t changed_meanwhile = 4 * 36 * 36 * 36 * 36 + 1;
/// A file for the ground or the state of a component. A larger blob is refused with `capacity_exceeded`.
inline constexpr std::size_t max_postgres_blob_bytes = std::max(
    (limits::max_transfer_bytes + blob_chunk_bytes - 1) / blob_chunk_bytes * blob_chunk_bytes, std::size_t{1} << 20U);

/// A transaction has the store to itself, as in SQLite, from its first write or its first question whose answer
/// is not known (also from last() as its first question): the others wait for it, up to 15 s (`store_error`). What it
/// has read before has to be true still, or it is refused (`store_error`, a = changed_meanwhile). Writes are sent
/// ahead, so a fault of one may be returned by a later call, by commit() at the latest. After `store_lost` every call
/// fails until reconnect(). libpq allocates memory. An object has several MiB: it does not belong on a stack.
class PostgresStore final : public Store, public StoreSharing {
 public:
  PostgresStore() = default;
  ~PostgresStore() { close(); }

  /// `conninfo` as libpq takes it: words and values, or postgresql://... An empty database gets the tables; those of
  /// another version are refused with `store_schema` (a = its fingerprint, b = ours) and left untouched; so is a
  /// database whose encoding is not SQL_ASCII (a = -1). wait() ends for changes of `watched`.
  /// `capacity_exceeded` for a text that is too long.
  Status open(const char* conninfo, RecordMask watched, PostgresOptions options = {});
  void close();
  /// Limits the bytes of blobs and of the tables' pages to about `bytes`. A put beyond it is `store_full`; erasing goes
  /// on. 0: no limit.
  void limit(std::int64_t bytes) { limit_bytes_ = bytes; }
  /// Whether open() has made the tables.
  [[nodiscard]] bool made_tables() const { return made_tables_; }
  /// Says in a sentence why the latest call failed. It holds no password.
  [[nodiscard]] const char* message() const { return connection_.message(); }

  Status begin() override;
  Status commit() override;
  void rollback() override;
  Status put(const RecordInfo& info, const void* record) override;
  Status get(const RecordInfo& info, std::int64_t id, void* record) override;
  Status next(const RecordInfo& info, std::int64_t after, void* record) override;
  Status last(const RecordInfo& info, void* record) override;
  Status erase(const RecordInfo& info, std::int64_t id) override;
  Status count(const RecordInfo& info, std::int64_t& records) override;
  Status write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                    std::span<const std::uint8_t> bytes) override;
  Status read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                   std::span<std::uint8_t> bytes) override;
  Status poll(RecordMask& changed) override;
  /// Bytes of all blobs and of the tables' pages. Indexes and what the server has yet to clean up do not count. While
  /// less than half of the limit is used, the number is up to a second old, with what this process has put since.
  StoreUsage usage() override;

  Status claim(StageMask stages) override;
  void release() override;
  [[nodiscard]] bool connected() const override { return connection_.alive(); }
  Status reconnect() override;
  /// By a connection of its own, because the server synchronises nothing in the middle of a transaction. `not_ready` if
  /// that one is lost: try again.
  Status flush() override;
  void wait(std::int32_t milliseconds) override;

 private:
  static constexpr std::size_t record_count = static_cast<std::size_t>(RecordType::count);
  static constexpr std::size_t none = ~std::size_t{0};
  static constexpr std::size_t most_guesses = 3;
  /// The next row and those behind it.
  static constexpr int rows_of_a_question = 4;

  /// Enough for an image and a depth map with its errors, while others are written.
  static constexpr std::size_t most_held = 6;
  /// A smaller blob is not kept when it is written: few of them are read again.
  static constexpr std::size_t least_kept_bytes = std::size_t{128} << 10U;

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
  /// The record that this transaction has put last: the server has yet to get the sizes of its blobs.
  struct LatestPut {
    const RecordInfo* info = nullptr;
    std::int64_t id = 0;
    std::array<std::uint32_t, max_blob_fields> bytes{};
    std::array<bool, max_blob_fields> sent{};
  };
  /// Answers that the next collect() brings.
  struct Awaited {
    std::size_t look = none, answer = none, change = none;
  };

  Status connect();
  Status set_up();
  Status check_schema();
  Status create_schema();
  Result<bool> has_tables();
  Status integer_of(const char* sql, std::int64_t& value);

  Status prepare(std::size_t statement, postgres::RowVerb verb, const RecordInfo& info);
  Status prepare(std::size_t statement, postgres::BlobVerb verb, const RecordInfo& info, std::size_t blob);
  Status prepare(std::size_t statement, void (*text)(postgres::SqlText&));
  Status send(postgres::RowVerb verb, const RecordInfo& info, const postgres::Parameters& parameters, bool keep);
  Status send(postgres::BlobVerb verb, const RecordInfo& info, std::size_t blob, const postgres::Parameters& parameters,
              bool keep);
  Status send_special(std::size_t which, void (*text)(postgres::SqlText&), const postgres::Parameters& parameters);
  Status send_look();
  /// Statements without parameters and answer.
  enum class Fixed : std::uint8_t { begin, lock, commit, rollback, flush };
  Status send_fixed(Fixed which);
  /// Sends the beginning of the transaction, if that is still to be done.
  Status start();
  Status check_early_reads();
  Status make_room();
  Status collect();
  /// Collects the answer to the statement that was sent last.
  Status collect_answer();

  Status writable();
  Status written(const RecordInfo& info, Status status);
  Status send_put(const RecordInfo& info, const void* record);
  Status send_commit();
  Status check_limit(const RecordInfo& info, const void* record);
  Status put_record(const RecordInfo& info, const void* record);
  /// Whether there was one.
  Result<bool> erase_record(const RecordInfo& info, std::int64_t id);
  void end_transaction();

  Status send_question(const postgres::Asked& asked, int most);
  /// Whether it is worth no question.
  [[nodiscard]] bool probably_known(const postgres::Asked& asked);
  Status begin_question();
  Status ask(const postgres::Asked& asked, int most);
  void keep_answer(const postgres::Asked& asked, std::size_t place, int most);
  void keep_walk(const RecordInfo& info, std::int64_t after, std::size_t place, int most);
  /// `not_ready`: the server has to be asked; so does read_early().
  Status known(const postgres::Asked& asked, void* record);
  Status read_row(const RecordInfo& info, std::size_t place, int row, void* record) const;
  Status read_early(const postgres::Asked& asked, void* record);
  Status read_granted(const postgres::Asked& asked, int most, void* record);
  Status read(const postgres::Asked& asked, int most, void* record);
  Status read_used_bytes(std::int64_t& bytes);
  Status read_blob_sizes(const RecordInfo& info, std::int64_t id, std::int64_t& bytes);

  Status send_latest_sizes();
  Status send_held_blob();
  Status send_fill(const BlobName& blob, std::span<const std::uint8_t> sums, std::span<const std::uint8_t> bytes);
  Status stated_size(const RecordInfo& info, const BlobName& blob, std::size_t bytes);
  Status check_range(const RecordInfo& info, const BlobName& blob, std::size_t offset, std::size_t bytes);
  /// Makes the blob the held one. Its size is that of the server.
  Status hold_blob(const RecordInfo& info, BlobName& blob);
  Status take_blob(BlobName& blob);
  Status size_for_write(const RecordInfo& info, BlobName& blob);
  Status write_whole(const BlobName& blob, std::span<const std::uint8_t> bytes);
  Status write_part(std::size_t offset, std::span<const std::uint8_t> bytes);
  Status read_part(std::size_t offset, std::span<std::uint8_t> bytes) const;
  [[nodiscard]] bool chunk_is_sound(std::size_t chunk) const;
  void set_sum(std::size_t chunk);
  [[nodiscard]] std::span<std::uint8_t> held_chunk(std::size_t chunk);
  [[nodiscard]] HeldBlob* find_held(const BlobName& blob);
  /// An empty place, or that of the blob that was used longest ago, becomes the latest one.
  void take_place();
  void drop_held(RecordMask tables);
  void drop_held_of(RecordType type, std::int64_t id);

  Status take_look();
  void take_change();
  Status receive();
  void take_notifications();
  void note_changes(RecordMask tables, std::int64_t commit);
  Status look();
  Status try_claim(StageMask stages, StageMask& taken);

  postgres::Connection connection_;
  postgres::Connection flusher_;  ///< of flush(), from its first call on
  FixedText<postgres::max_conninfo_bytes> conninfo_;
  RecordMask watched_ = 0;
  PostgresOptions options_;
  StageMask claimed_ = 0;
  bool made_tables_ = false;

  bool in_transaction_ = false;
  bool started_ = false;  ///< the server knows of the transaction
  Status doomed_;         ///< the fault that made a commit of this transaction impossible
  RecordMask uncommitted_ = 0;
  RecordMask touched_ = 0;  ///< also by writes that failed
  LatestPut latest_;
  Awaited awaited_;

  postgres::AnswerCache answers_;
  postgres::Guesses guesses_;
  postgres::EarlyReads early_;
  RecordMask changed_early_ = 0;                        ///< by others, since the transaction was begun
  std::array<std::int64_t, record_count> walked_to_{};  ///< id that the latest next() has returned
  std::array<HeldBlob, most_held> blobs_;
  HeldBlob* held_ = blobs_.data();  ///< the latest one
  std::uint64_t blob_uses_ = 0;

  RecordMask changed_ = 0;                            ///< since the latest poll()
  RecordMask unread_ = 0;                             ///< changed by the look that came with an answer
  std::array<std::int64_t, record_count> numbers_{};  ///< commit that changed the table last, as far as it is known
  std::int64_t heard_ = 0;                            ///< all commits up to this one are known
  bool heard_others_ = true;                          ///< since the latest flush()
  bool look_now_ = false;
  std::int64_t looked_ms_ = 0;

  std::int64_t limit_bytes_ = 0;
  std::int64_t used_bytes_ = 0;
  std::int64_t asked_bytes_ = 0;  ///< of blobs put since used_bytes_ was read
  bool used_is_known_ = false;
  std::int64_t used_ms_ = -postgres_look_ms;  ///< when it was read
};

}  // namespace ilp
