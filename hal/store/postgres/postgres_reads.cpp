// Reads of the store on a server: from the answers that are known, or with one round trip.
#include <cstring>
#include <limits>

#include "fsw/records/records.hpp"
#include "hal/store/postgres/columns.hpp"
#include "hal/store/postgres/postgres_store.hpp"

namespace ilp {

using namespace postgres;

namespace {

// A walk that goes on where it was asks for many rows; a single question for the next row and the one behind it.
constexpr int rows_of_a_walk = 32;
constexpr int rows_of_a_question = 4;

}  // namespace

/// Sends a statement behind all others and collects its answer. Outside a transaction a look at the changes follows, so
/// that what is known of other tables is never older than what this answer shows.
Status PostgresStore::ask(const RecordInfo& info, RowVerb verb, const Parameters& parameters) {
  if (!connected()) return StatusCode::store_lost;
  if (in_transaction_ && !doomed_.ok()) return doomed_;
  ILP_TRY(make_room());
  ILP_TRY(start());
  awaited_.answer = connection_.next_place();
  ILP_TRY(send(verb, info, parameters, true));
  return collect_answer();
}

Status PostgresStore::collect_answer() {
  if (!in_transaction_) ILP_TRY(send_look());
  unread_ = 0;
  return collect();
}

/// An answer that came before the change of its table may be older than what is known.
bool PostgresStore::may_keep(const RecordInfo& info) const {
  return in_transaction_ || (unread_ & mask_of(info.type)) == 0;
}

/// What is known inside a transaction is true as soon as the server has granted it. Outside, a process that does not
/// poll has to look for changes once in a while.
Status PostgresStore::known(const RecordInfo& info, Question question, std::int64_t key, void* record, bool& is_known) {
  is_known = false;
  if (!connected()) return StatusCode::store_lost;
  if (in_transaction_ && !doomed_.ok()) return doomed_;
  const bool granted = started_ && awaited_.look == none;
  if (in_transaction_ ? !granted : steady_ms() - looked_ms_ >= postgres_look_ms) return {};
  AnswerCache::Answer answer;
  is_known = answers_.find(info, question, key, answer);
  if (!is_known) return {};
  if (!answer.found) return {StatusCode::not_found, key};
  std::memcpy(record, answer.record, info.bytes);
  return {};
}

Status PostgresStore::read_row(const RecordInfo& info, int row, void* record) const {
  const Rows& rows = connection_.rows(awaited_.answer);
  alignas(8) unsigned char read[limits::max_record_bytes] = {};
  if (read_record(info, rows, row, read)) {
    std::memcpy(record, read, info.bytes);
    return {};
  }
  std::int64_t id = 0;
  if (!rows.integer(row, 0, id)) return {StatusCode::store_damaged, 0, static_cast<std::int64_t>(info.type)};
  return {StatusCode::record_damaged, id, static_cast<std::int64_t>(info.type)};
}

Status PostgresStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  bool is_known = false;
  const Status found = known(info, Question::get, id, record, is_known);
  if (is_known || !found.ok()) return found;
  Parameters parameters;
  parameters.add(id);
  ILP_TRY(ask(info, RowVerb::get, parameters));
  const bool there = connection_.rows(awaited_.answer).count() != 0;
  const Status status = there ? read_row(info, 0, record) : Status{StatusCode::not_found, id};
  if (may_keep(info) && (status.ok() || !there)) answers_.keep(info, Question::get, id, there ? record : nullptr);
  connection_.clear();
  return status;
}

Status PostgresStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  bool is_known = false;
  Status status = known(info, Question::next, after, record, is_known);
  std::int64_t& walked_to = walked_to_[static_cast<std::size_t>(info.type)];
  if (!is_known && status.ok()) {
    status = walk(info, after, after == walked_to ? rows_of_a_walk : rows_of_a_question, record);
  }
  if (status.ok()) walked_to = id_of(record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found} : status;
}

Status PostgresStore::walk(const RecordInfo& info, std::int64_t after, int most, void* record) {
  Parameters parameters;
  parameters.add(after).add(std::int64_t{most});
  ILP_TRY(ask(info, RowVerb::next, parameters));
  const int count = connection_.rows(awaited_.answer).count();
  Status status = count == 0 ? Status{StatusCode::not_found} : read_row(info, 0, record);
  const std::int64_t id = status.ok() ? id_of(record) : status.a;
  // In a damaged index a walk could run in a circle for ever.
  const bool goes_back = (status.ok() || status.is(StatusCode::record_damaged)) && id <= after;
  if (goes_back) status = {StatusCode::store_damaged, id, static_cast<std::int64_t>(info.type)};
  std::int64_t before = after;
  alignas(8) unsigned char row[limits::max_record_bytes];
  for (int i = 0; i < count && status.ok() && may_keep(info); ++i) {
    if (!read_row(info, i, row).ok() || id_of(row) <= before) break;
    answers_.keep(info, Question::next, before, row);
    answers_.keep(info, Question::get, id_of(row), row);
    before = id_of(row);
    if (i + 1 == count && count < most) answers_.keep(info, Question::next, before, nullptr);
  }
  if (count == 0 && may_keep(info)) answers_.keep(info, Question::next, after, nullptr);
  connection_.clear();
  return status;
}

Status PostgresStore::last(const RecordInfo& info, void* record) {
  bool is_known = false;
  const Status found = known(info, Question::last, 0, record, is_known);
  if (is_known) return found.ok() ? found : Status{StatusCode::not_found};
  ILP_TRY(found);
  ILP_TRY(ask(info, RowVerb::last, {}));
  const bool there = connection_.rows(awaited_.answer).count() != 0;
  const Status status = there ? read_row(info, 0, record) : Status{StatusCode::not_found};
  if (may_keep(info) && (status.ok() || !there)) answers_.keep(info, Question::last, 0, there ? record : nullptr);
  connection_.clear();
  return status;
}

Status PostgresStore::count(const RecordInfo& info, std::int64_t& records) {
  ILP_TRY(ask(info, RowVerb::count, {}));
  const bool told = connection_.rows(awaited_.answer).integer(0, 0, records);
  connection_.clear();
  return told ? Status{} : Status{StatusCode::store_damaged, 0, static_cast<std::int64_t>(info.type)};
}

Status PostgresStore::read_used_bytes(std::int64_t& bytes) {
  if (!connected()) return StatusCode::store_lost;
  if (in_transaction_ && !doomed_.ok()) return doomed_;
  ILP_TRY(make_room());
  ILP_TRY(start());
  if (in_transaction_) ILP_TRY(send_latest_sizes());
  awaited_.answer = connection_.next_place();
  ILP_TRY(send_special(2, used_bytes, {}));
  ILP_TRY(collect_answer());
  const bool told = connection_.rows(awaited_.answer).integer(0, 0, bytes);
  connection_.clear();
  return told ? Status{} : Status{StatusCode::store_damaged};
}

/// Of all blobs of a record, as they are on the server.
Status PostgresStore::read_blob_sizes(const RecordInfo& info, std::int64_t id, std::int64_t& bytes) {
  Status status;
  bytes = 0;
  for_each_blob(info, [&](const FieldInfo&, std::size_t blob) {
    if (!status.ok()) return;
    Parameters parameters;
    parameters.add(id).add(std::int64_t{0});
    awaited_.answer = connection_.next_place();
    status = send(BlobVerb::read, info, blob, parameters, true);
    if (status.ok()) status = collect_answer();
    std::int64_t size = 0;
    if (status.ok() && connection_.rows(awaited_.answer).integer(0, 0, size) && size > 0 &&
        size <= std::int64_t{max_postgres_blob_bytes}) {
      bytes += size;
    }
    connection_.clear();
  });
  return status;
}

StoreUsage PostgresStore::usage() {
  std::int64_t bytes = 0;
  if (read_used_bytes(bytes).ok()) {
    used_bytes_ = bytes;
    asked_bytes_ = 0;
  }
  return {used_bytes_, 0, limit_bytes_};
}

}  // namespace ilp
