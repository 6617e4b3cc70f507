// Reads records of the store on a server, from the cache of answers or with one round trip.
#include <cstring>

#include "fsw/records/records.hpp"
#include "hal/store/postgres/columns.hpp"
#include "hal/store/postgres/session.hpp"

namespace ilp::postgres {
namespace {

// A walk that goes on where it was asks for many rows.
constexpr int rows_of_a_walk = 32;
/// The next row and those behind it.
constexpr int rows_of_a_question = 4;

struct Asked {
  RecordType type;
  RowVerb verb;
  std::int64_t key;
};

Question question_of(RowVerb verb) {
  return verb == RowVerb::get ? Question::get : verb == RowVerb::next ? Question::next : Question::last;
}

Status send_question(Session& s, const Asked& asked, int most) {
  const RecordInfo& info = record_info(asked.type);
  Parameters parameters;
  if (asked.verb == RowVerb::get || asked.verb == RowVerb::next) parameters.add(asked.key);
  if (asked.verb == RowVerb::next) parameters.add(std::int64_t{most});
  return send(s, asked.verb, info, parameters, true);
}

/// Whether a question can be asked; a transaction begins with it.
Status begin_question(Session& s) {
  if (!s.connection.alive()) return StatusCode::store_lost;
  if (s.transaction.open && !s.transaction.doomed.ok()) return s.transaction.doomed;
  ILP_TRY(make_room(s));
  return start(s);
}

Status read_row(const Session& s, const RecordInfo& info, std::size_t place, int row, void* record) {
  const Rows& rows = s.connection.rows(place);
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

void keep_walk(Session& s, const RecordInfo& info, std::int64_t after, std::size_t place, int most) {
  const int count = s.connection.rows(place).count();
  alignas(8) unsigned char row[limits::max_record_bytes];
  for (int i = 0; i < count; ++i) {
    if (!read_row(s, info, place, i, row).ok() || id_of(row) <= after) return;
    s.answers.keep(info, Question::next, after, row);
    s.answers.keep(info, Question::get, id_of(row), row);
    after = id_of(row);
  }
  if (count < most) s.answers.keep(info, Question::next, after, nullptr);
}

/// An answer that came before the change of its table may be older than what is known.
void keep_answer(Session& s, const Asked& asked, std::size_t place, int most) {
  const RecordInfo& info = record_info(asked.type);
  if (asked.verb == RowVerb::count || (!s.transaction.open && (s.changes.unread & mask_of(asked.type)) != 0)) return;
  if (asked.verb == RowVerb::next) {
    keep_walk(s, info, asked.key, place, most);
    return;
  }
  const Question question = question_of(asked.verb);
  alignas(8) unsigned char row[limits::max_record_bytes];
  if (s.connection.rows(place).count() == 0) {
    s.answers.keep(info, question, asked.key, nullptr);
  } else if (read_row(s, info, place, 0, row).ok()) {
    s.answers.keep(info, question, asked.key, row);
  }
}

/// Sends a question behind all other statements and collects its answer. Outside of a transaction a look at the changes
/// follows, so that what is known of other tables is never older than what this answer shows.
Status ask(Session& s, const Asked& asked, int most) {
  ILP_TRY(begin_question(s));
  const std::size_t place = s.connection.next_place();
  s.awaited.answer = place;
  ILP_TRY(send_question(s, asked, most));
  ILP_TRY(collect_answer(s));
  keep_answer(s, asked, place, most);
  return {};
}

/// What is known inside a transaction is true as soon as the server has granted it. Outside, a process that does not
/// poll has to look for changes once in a while.
Status known(Session& s, const Asked& asked, void* record) {
  if (!s.connection.alive()) return StatusCode::store_lost;
  if (s.transaction.open && !s.transaction.doomed.ok()) return s.transaction.doomed;
  const bool granted = s.transaction.started && s.awaited.look == no_place;
  if (s.transaction.open ? !granted : steady_ms() - s.changes.polled_ms >= postgres_poll_ms)
    return StatusCode::not_ready;
  AnswerCache::Answer answer;
  const RecordInfo& info = record_info(asked.type);
  if (!s.answers.find(info, question_of(asked.verb), asked.key, answer)) return StatusCode::not_ready;
  if (!answer.found) return {StatusCode::not_found, asked.key};
  std::memcpy(record, answer.record, info.bytes);
  return {};
}

Status read(Session& s, const Asked& asked, int most, void* record) {
  const Status found = known(s, asked, record);
  if (!found.is(StatusCode::not_ready)) return found;
  ILP_TRY(ask(s, asked, most));
  const Status status = read_row(s, record_info(asked.type), s.awaited.answer, 0, record);
  s.connection.clear();
  return status;
}

}  // namespace

Status collect_answer(Session& s) {
  if (!s.transaction.open) ILP_TRY(send_look(s));
  s.changes.unread = 0;
  return collect(s);
}

Status get(Session& s, const RecordInfo& info, std::int64_t id, void* record) {
  const Status status = read(s, {info.type, RowVerb::get, id}, 1, record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found, id} : status;
}

Status next(Session& s, const RecordInfo& info, std::int64_t after, void* record) {
  std::int64_t& walked_to = s.walked_to[static_cast<std::size_t>(info.type)];
  const int most = after == walked_to ? rows_of_a_walk : rows_of_a_question;
  const Status status = read(s, {info.type, RowVerb::next, after}, most, record);
  if (status.is(StatusCode::not_found)) return StatusCode::not_found;
  const bool damaged = status.is(StatusCode::record_damaged);
  // In a damaged index a walk could run in a circle for ever.
  if ((status.ok() && id_of(record) <= after) || (damaged && status.a <= after)) {
    return {StatusCode::store_damaged, after, static_cast<std::int64_t>(info.type)};
  }
  if (status.ok()) walked_to = id_of(record);
  return status;
}

Status last(Session& s, const RecordInfo& info, void* record) {
  const Status status = read(s, {info.type, RowVerb::last, 0}, 1, record);
  return status.is(StatusCode::not_found) ? Status{StatusCode::not_found} : status;
}

Status count(Session& s, const RecordInfo& info, std::int64_t& records) {
  ILP_TRY(ask(s, {info.type, RowVerb::count, 0}, 1));
  const bool reported = s.connection.rows(s.awaited.answer).number(0, 0, records);
  s.connection.clear();
  return reported ? Status{} : Status{StatusCode::store_damaged, 0, static_cast<std::int64_t>(info.type)};
}

Status read_used_bytes(Session& s, std::int64_t& bytes) {
  ILP_TRY(begin_question(s));
  if (s.transaction.open) ILP_TRY(send_latest_sizes(s));
  s.awaited.answer = s.connection.next_place();
  ILP_TRY(send_special(s, 2, used_bytes, {}));
  ILP_TRY(collect_answer(s));
  const bool reported = s.connection.rows(s.awaited.answer).number(0, 0, bytes);
  s.connection.clear();
  return reported ? Status{} : Status{StatusCode::store_damaged};
}

Status read_blob_sizes(Session& s, const RecordInfo& info, std::int64_t id, std::int64_t& bytes) {
  Status status;
  bytes = 0;
  for_each_blob(info, [&](const FieldInfo&, std::size_t blob) {
    if (!status.ok()) return;
    Parameters parameters;
    parameters.add(id).add(std::int64_t{0});
    s.awaited.answer = s.connection.next_place();
    status = send(s, BlobVerb::read, info, blob, parameters, true);
    if (status.ok()) status = collect_answer(s);
    std::int64_t size = 0;
    if (status.ok() && s.connection.rows(s.awaited.answer).number(0, 0, size) && size > 0 &&
        size <= std::int64_t{max_postgres_blob_bytes}) {
      bytes += size;
    }
    s.connection.clear();
  });
  return status;
}

StoreUsage usage(Session& s) {
  const bool granted = !s.transaction.open || (s.transaction.started && s.awaited.look == no_place);
  const std::int64_t now = steady_ms();
  const bool is_it =
      s.capacity.used_is_known && granted && s.transaction.touched == 0 && now - s.changes.polled_ms < postgres_poll_ms;
  const bool much_capacity =
      s.capacity.limit_bytes != 0 && 2 * (s.capacity.used_bytes + s.capacity.asked_bytes) < s.capacity.limit_bytes;
  const bool known = is_it || (much_capacity && now - s.capacity.used_ms < postgres_poll_ms);
  std::int64_t bytes = 0;
  if (!known && read_used_bytes(s, bytes).ok()) {
    s.capacity.used_bytes = bytes;
    s.capacity.asked_bytes = 0;
    s.capacity.used_ms = now;
    s.capacity.used_is_known = s.transaction.touched == 0 && s.changes.unread == 0;
  }
  return {is_it || !known ? s.capacity.used_bytes : s.capacity.used_bytes + s.capacity.asked_bytes, 0,
          s.capacity.limit_bytes};
}

}  // namespace ilp::postgres
