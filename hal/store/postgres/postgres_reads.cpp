// Reads of the store on a server: from the answers that are known, or with one round trip.
#include <array>
#include <cstring>

#include "fsw/records/records.hpp"
#include "hal/store/postgres/columns.hpp"
#include "hal/store/postgres/postgres_store.hpp"

namespace ilp {

using namespace postgres;

namespace {

// A walk that goes on where it was asks for many rows.
constexpr int rows_of_a_walk = 32;

Question question_of(RowVerb verb) {
  return verb == RowVerb::get ? Question::get : verb == RowVerb::next ? Question::next : Question::last;
}

}  // namespace

Status PostgresStore::send_question(const Asked& asked, int most) {
  const RecordInfo& info = record_info(asked.type);
  Parameters parameters;
  if (asked.verb == RowVerb::get || asked.verb == RowVerb::next) parameters.add(asked.key);
  if (asked.verb == RowVerb::next) parameters.add(std::int64_t{most});
  return send(asked.verb, info, parameters, true);
}

bool PostgresStore::probably_known(const Asked& asked) {
  AnswerCache::Answer answer;
  return asked.verb != RowVerb::count &&
         answers_.find(record_info(asked.type), question_of(asked.verb), asked.key, answer);
}

/// Whether a question can be asked; a transaction begins with it.
Status PostgresStore::begin_question() {
  if (!connected()) return StatusCode::store_lost;
  if (in_transaction_ && !doomed_.ok()) return doomed_;
  ILP_TRY(make_room());
  return start();
}

/// Sends a question behind all other statements and collects its answer; in a transaction also the answers to the
/// questions that will probably follow. Outside a look at the changes follows, so that what is known of other tables is
/// never older than what this answer shows.
Status PostgresStore::ask(const Asked& asked, int most) {
  ILP_TRY(make_room());
  const std::size_t place = connection_.next_place();
  awaited_.answer = place;
  ILP_TRY(send_question(asked, most));
  std::array<Asked, most_guesses> guessed;
  std::size_t guesses = 0;
  Asked next = asked;
  for (std::size_t i = 0; i < 2 * most_guesses && in_transaction_ && guesses < most_guesses; ++i) {
    next = guesses_.after(next);
    if (next.type == RecordType::count || next == asked) break;
    if (probably_known(next)) continue;
    guessed[guesses++] = next;
    ILP_TRY(send_question(next, rows_of_a_question));
  }
  if (in_transaction_) guesses_.learn(asked);
  ILP_TRY(collect_answer());
  keep_answer(asked, place, most);
  for (std::size_t g = 0; g < guesses; ++g) keep_answer(guessed[g], place + 1 + g, rows_of_a_question);
  return {};
}

/// An answer that came before the change of its table may be older than what is known.
void PostgresStore::keep_answer(const Asked& asked, std::size_t place, int most) {
  const RecordInfo& info = record_info(asked.type);
  if (asked.verb == RowVerb::count || (!in_transaction_ && (unread_ & mask_of(asked.type)) != 0)) return;
  if (asked.verb == RowVerb::next) {
    keep_walk(info, asked.key, place, most);
    return;
  }
  const Question question = question_of(asked.verb);
  alignas(8) unsigned char row[limits::max_record_bytes];
  if (connection_.rows(place).count() == 0) {
    answers_.keep(info, question, asked.key, nullptr);
  } else if (read_row(info, place, 0, row).ok()) {
    answers_.keep(info, question, asked.key, row);
  }
}

void PostgresStore::keep_walk(const RecordInfo& info, std::int64_t after, std::size_t place, int most) {
  const int count = connection_.rows(place).count();
  alignas(8) unsigned char row[limits::max_record_bytes];
  for (int i = 0; i < count; ++i) {
    if (!read_row(info, place, i, row).ok() || id_of(row) <= after) return;
    answers_.keep(info, Question::next, after, row);
    answers_.keep(info, Question::get, id_of(row), row);
    after = id_of(row);
  }
  if (count < most) answers_.keep(info, Question::next, after, nullptr);
}

Status PostgresStore::collect_answer() {
  if (!in_transaction_) ILP_TRY(send_look());
  unread_ = 0;
  return collect();
}

/// What is known inside a transaction is true as soon as the server has granted it. Outside, a process that does not
/// poll has to look for changes once in a while.
Status PostgresStore::known(const Asked& asked, void* record) {
  if (!connected()) return StatusCode::store_lost;
  if (in_transaction_ && !doomed_.ok()) return doomed_;
  const bool granted = started_ && awaited_.look == none;
  if (in_transaction_ ? !granted : steady_ms() - looked_ms_ >= postgres_look_ms) return StatusCode::not_ready;
  AnswerCache::Answer answer;
  const RecordInfo& info = record_info(asked.type);
  if (!answers_.find(info, question_of(asked.verb), asked.key, answer)) return StatusCode::not_ready;
  if (!answer.found) return {StatusCode::not_found, asked.key};
  std::memcpy(record, answer.record, info.bytes);
  return {};
}

Status PostgresStore::read_row(const RecordInfo& info, std::size_t place, int row, void* record) const {
  const Rows& rows = connection_.rows(place);
  if (rows.count() == 0) return StatusCode::not_found;
  alignas(8) unsigned char read[limits::max_record_bytes] = {};
  if (read_record(info, rows, row, read)) {
    std::memcpy(record, read, info.bytes);
    return {};
  }
  std::int64_t id = 0;
  if (!rows.number(row, 0, id)) return {StatusCode::store_damaged, 0, static_cast<std::int64_t>(info.type)};
  return {StatusCode::record_damaged, id, static_cast<std::int64_t>(info.type)};
}

/// Before the transaction has the store to itself: what is known, as outside of a transaction. One that begins by
/// asking for the newest record is about to put the next one, and others may be as well; so it takes the lock.
Status PostgresStore::read_early(const Asked& asked, void* record) {
  if (!connected()) return StatusCode::store_lost;
  if (!doomed_.ok()) return doomed_;
  if (early_.full() || (early_.empty() && asked.verb == RowVerb::last)) return StatusCode::not_ready;
  if (early_.empty()) {
    ILP_TRY(connection_.receive());
    take_notifications();
    changed_early_ = 0;
  }
  if (look_now_ || steady_ms() - looked_ms_ >= postgres_look_ms) return StatusCode::not_ready;
  const RecordInfo& info = record_info(asked.type);
  AnswerCache::Answer answer;
  if (!answers_.find(info, question_of(asked.verb), asked.key, answer)) return StatusCode::not_ready;
  early_.note(asked, info, answer.found ? answer.record : nullptr);
  if (!answer.found) return {StatusCode::not_found, asked.key};
  std::memcpy(record, answer.record, info.bytes);
  return {};
}

/// Outside of a transaction, or in one that has begun on the server.
Status PostgresStore::read_granted(const Asked& asked, int most, void* record) {
  const Status found = known(asked, record);
  if (!found.is(StatusCode::not_ready)) return found;
  ILP_TRY(ask(asked, most));
  const Status status = read_row(record_info(asked.type), awaited_.answer, 0, record);
  connection_.clear();
  return status;
}

Status PostgresStore::read(const Asked& asked, int most, void* record) {
  if (in_transaction_ && !started_) {
    const Status found = read_early(asked, record);
    if (!found.is(StatusCode::not_ready)) return found;
    ILP_TRY(start());
  }
  return read_granted(asked, most, record);
}

Status PostgresStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  const Status status = read({info.type, RowVerb::get, id}, 1, record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found, id} : status;
}

Status PostgresStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  std::int64_t& walked_to = walked_to_[static_cast<std::size_t>(info.type)];
  const int most = after == walked_to ? rows_of_a_walk : rows_of_a_question;
  const Status status = read({info.type, RowVerb::next, after}, most, record);
  if (status.is(StatusCode::not_found)) return StatusCode::not_found;
  const bool damaged = status.is(StatusCode::record_damaged);
  // In a damaged index a walk could run in a circle for ever.
  if ((status.ok() && id_of(record) <= after) || (damaged && status.a <= after)) {
    return {StatusCode::store_damaged, after, static_cast<std::int64_t>(info.type)};
  }
  if (status.ok()) walked_to = id_of(record);
  return status;
}

Status PostgresStore::last(const RecordInfo& info, void* record) {
  const Status status = read({info.type, RowVerb::last, 0}, 1, record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found} : status;
}

Status PostgresStore::count(const RecordInfo& info, std::int64_t& records) {
  ILP_TRY(begin_question());
  ILP_TRY(ask({info.type, RowVerb::count, 0}, 1));
  const bool told = connection_.rows(awaited_.answer).number(0, 0, records);
  connection_.clear();
  return told ? Status{} : Status{StatusCode::store_damaged, 0, static_cast<std::int64_t>(info.type)};
}

Status PostgresStore::read_used_bytes(std::int64_t& bytes) {
  ILP_TRY(begin_question());
  if (in_transaction_) ILP_TRY(send_latest_sizes());
  awaited_.answer = connection_.next_place();
  ILP_TRY(send_special(2, used_bytes, {}));
  ILP_TRY(collect_answer());
  const bool told = connection_.rows(awaited_.answer).number(0, 0, bytes);
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
    if (status.ok() && connection_.rows(awaited_.answer).number(0, 0, size) && size > 0 &&
        size <= std::int64_t{max_postgres_blob_bytes}) {
      bytes += size;
    }
    connection_.clear();
  });
  return status;
}

StoreUsage PostgresStore::usage() {
  const bool granted = !in_transaction_ || (started_ && awaited_.look == none);
  const std::int64_t now = steady_ms();
  const bool is_it = used_is_known_ && granted && touched_ == 0 && now - looked_ms_ < postgres_look_ms;
  const bool much_room = limit_bytes_ != 0 && 2 * (used_bytes_ + asked_bytes_) < limit_bytes_;
  const bool known = is_it || (much_room && now - used_ms_ < postgres_look_ms);
  std::int64_t bytes = 0;
  if (!known && read_used_bytes(bytes).ok()) {
    used_bytes_ = bytes;
    asked_bytes_ = 0;
    used_ms_ = now;
    used_is_known_ = touched_ == 0 && unread_ == 0;
  }
  return {is_it || !known ? used_bytes_ : used_bytes_ + asked_bytes_, 0, limit_bytes_};
}

}  // namespace ilp
