#include "hal/store/postgres/session.hpp"

#include "fsw/base/argument.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/postgres/columns.hpp"
#include "hal/store/postgres/settings.hpp"

namespace ilp::postgres {
namespace {

constexpr std::size_t row_verbs = static_cast<std::size_t>(RowVerb::end);
constexpr std::size_t blob_verbs = static_cast<std::size_t>(BlobVerb::end);
constexpr std::size_t of_record = row_verbs + max_blob_fields * blob_verbs;
constexpr std::size_t first_special = of_record * static_cast<std::size_t>(RecordType::count);
constexpr std::size_t first_fixed = first_special + 3;
static_assert(first_special + 8 <= Connection::max_statements);

const FieldInfo& blob_field(const RecordInfo& info, std::size_t blob) {
  const FieldInfo* found = info.fields;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    if (index == blob) found = &field;
  });
  return *found;
}

/// Statements without parameters and answer.
enum class Fixed : std::uint8_t { begin, lock, commit, rollback, flush };

Status send_fixed(Session& s, Fixed which) {
  static constexpr const char* texts[] = {begin_statement, lock_statement, commit_statement, rollback_statement,
                                          flush_statement};
  const std::size_t statement = first_fixed + static_cast<std::size_t>(which);
  if (!s.connection.prepared(statement)) {
    ILP_TRY(s.connection.prepare(statement, texts[static_cast<std::size_t>(which)], 0));
  }
  return s.connection.send(statement, {}, 0, false);
}

Status set_up(Session& s) {
  for (const char* setting : session_settings) ILP_TRY(s.connection.send(setting, false));
  ILP_TRY(s.connection.send("LISTEN ilp", false));
  return s.connection.collect();
}

Status integer_of(Session& s, const char* sql, std::int64_t& value) {
  ILP_TRY(s.connection.send(sql, true));
  ILP_TRY(s.connection.collect());
  return s.connection.rows(0).number(0, 0, value) ? Status{} : Status{StatusCode::store_damaged};
}

/// Functions that look a name up, such as to_regclass, may answer what was true before this process waited for the
/// lock.
Result<bool> has_tables(Session& s) {
  std::int64_t found = 0;
  ILP_TRY(integer_of(s, "SELECT count(*) FROM pg_class WHERE relname='ilp_store' AND pg_table_is_visible(oid)", found));
  return found != 0;
}

/// One transaction: the server may end between any two statements, and another process may do the same.
Status create_schema(Session& s) {
  ILP_TRY(send_fixed(s, Fixed::begin));
  ILP_TRY(send_fixed(s, Fixed::lock));
  ILP_TAKE(const bool there, has_tables(s));
  SqlText sql;
  const auto send_text = [&] {
    const Status status = s.connection.send(sql.c_str(), false);
    sql.clear();
    return status;
  };
  for (std::size_t t = 0; t < record_count && !there; ++t) {
    const RecordInfo& info = record_info(static_cast<RecordType>(t));
    create_table(info, sql);
    Status status = send_text();
    for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
      create_blob_table(info, field, sql);
      if (status.ok()) status = send_text();
      keep_blob_external(info, field, sql);
      if (status.ok()) status = send_text();
    });
    ILP_TRY(status);
  }
  if (!there) {
    create_store_table(sql);
    ILP_TRY(send_text());
    fill_store_table(sql);
    ILP_TRY(send_text());
  }
  ILP_TRY(send_fixed(s, Fixed::commit));
  ILP_TRY(send_fixed(s, Fixed::flush));
  s.made_tables = !there;
  return s.connection.collect();
}

Status check_schema(Session& s) {
  if (!s.connection.texts_are_bytes()) return {StatusCode::store_schema, -1, schema_fingerprint()};
  ILP_TAKE(const bool there, has_tables(s));
  if (!there && !s.options.create) return StatusCode::not_found;
  if (!there) ILP_TRY(create_schema(s));
  std::int64_t fingerprint = 0;
  ILP_TRY(integer_of(s, "SELECT fingerprint FROM ilp_store", fingerprint));
  return fingerprint == schema_fingerprint() ? Status{}
                                             : Status{StatusCode::store_schema, fingerprint, schema_fingerprint()};
}

/// Of its own, so that the text is not on the stack beside the parameters; the others likewise.
[[gnu::noinline]] Status prepare(Session& s, std::size_t statement, RowVerb verb, const RecordInfo& info) {
  const auto table = static_cast<std::int64_t>(info.type);
  SqlText sql;
  row_statement(verb, info, sql);
  ILP_ASSERT(!sql.overflow(), table);
  return s.connection.prepare(statement, sql.c_str(), table);
}

[[gnu::noinline]] Status prepare(Session& s, std::size_t statement, BlobVerb verb, const RecordInfo& info,
                                 std::size_t blob) {
  SqlText sql;
  blob_statement(verb, info, blob_field(info, blob), sql);
  return s.connection.prepare(statement, sql.c_str(), static_cast<std::int64_t>(info.type));
}

[[gnu::noinline]] Status prepare(Session& s, std::size_t statement, void (*text)(SqlText&)) {
  SqlText sql;
  text(sql);
  ILP_ASSERT(!sql.overflow(), statement);
  return s.connection.prepare(statement, sql.c_str(), 0);
}

/// The transaction ends, the others are notified and may begin theirs, while this process waits until its changes are
/// on the server's disk. What they commit then comes behind it in the server's log, so none of it outlasts this one.
Status send_commit(Session& s) {
  const bool changes = s.transaction.uncommitted != 0;
  const std::size_t change = s.awaited.change;
  ILP_TRY(send_fixed(s, Fixed::commit));
  if (changes && s.options.synchronous) ILP_TRY(send_fixed(s, Fixed::flush));
  const Status status = collect(s);
  const bool may_be_carried_out = changes && s.connection.alive() && s.connection.rows(change).count() != 0;
  if (status.ok() || !may_be_carried_out) return status;
  s.connection.close();
  return {StatusCode::store_lost, status.a};
}

/// Counts what the store would grow by, at most. Only where that goes beyond the limit it is asked what there is.
Status check_limit(Session& s, const RecordInfo& info, const void* record) {
  std::int64_t bytes = 0;
  bool fits = true;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
    bytes += blob_bytes(record, field);
    fits = fits && blob_bytes(record, field) <= max_postgres_blob_bytes;
  });
  if (!fits) return {StatusCode::capacity_exceeded, bytes, max_postgres_blob_bytes};
  s.capacity.asked_bytes += bytes;
  if (bytes == 0 || s.capacity.limit_bytes == 0) return {};
  // Others put as well: eight processes together do not go beyond the limit.
  if (s.capacity.used_ms >= 0 && s.capacity.asked_bytes <= (s.capacity.limit_bytes - s.capacity.used_bytes) / 8)
    return {};
  std::int64_t before = 0;
  ILP_TRY(read_used_bytes(s, s.capacity.used_bytes));
  s.capacity.used_ms = steady_ms();
  ILP_TRY(read_blob_sizes(s, info, id_of(record), before));
  s.capacity.asked_bytes = bytes - before;
  if (s.capacity.used_bytes + s.capacity.asked_bytes <= s.capacity.limit_bytes) return {};
  return {StatusCode::store_full, s.capacity.used_bytes, s.capacity.limit_bytes};
}

Status send_put(Session& s, const RecordInfo& info, const void* record) {
  Parameters parameters;
  bind_record(info, record, parameters);
  return send(s, RowVerb::put, info, parameters, false);
}

Status put_record(Session& s, const RecordInfo& info, const void* record) {
  ILP_TRY(check_limit(s, info, record));
  ILP_TRY(send_latest_sizes(s));
  ILP_TRY(send_held_blob(s));
  ILP_TRY(start(s));
  ILP_TRY(make_room(s));
  ILP_TRY(send_put(s, info, record));
  s.transaction.latest = {&info, id_of(record), {}, {}};
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    s.transaction.latest.bytes[index] = blob_bytes(record, field);
    HeldBlob* const held = find_held(s, {info.type, index, id_of(record), 0});
    if (held != nullptr && held->name.bytes != s.transaction.latest.bytes[index]) held->forget();
  });
  alignas(8) std::uint8_t as_read[limits::max_record_bytes];
  canonical_record(info, record, as_read);
  s.answers.put(info, as_read);
  return {};
}

Result<bool> erase_record(Session& s, const RecordInfo& info, std::int64_t id) {
  ILP_TRY(send_latest_sizes(s));
  ILP_TRY(send_held_blob(s));
  ILP_TRY(start(s));
  ILP_TRY(make_room(s));
  drop_held_of(s, info.type, id);
  if (s.transaction.latest.info == &info && s.transaction.latest.id == id) s.transaction.latest = {};
  Parameters parameters;
  parameters.add(id);
  Status status;
  for_each_blob(info, [&](const FieldInfo&, std::size_t blob) {
    if (status.ok()) status = send(s, BlobVerb::erase, info, blob, parameters, false);
  });
  ILP_TRY(status);
  AnswerCache::Answer answer;
  ILP_TRY(send(s, RowVerb::erase, info, parameters, false));
  bool there = s.awaited.look == no_place && s.answers.find(info, Question::get, id, answer) && answer.found;
  if (!there) {
    ILP_TRY(collect(s));
    there = s.connection.rows_changed() != 0;
  }
  s.answers.erase(info, id);
  return there;
}

void end_transaction(Session& s) {
  s.transaction = {};
  s.awaited = {};
}

}  // namespace

void close(Session& s) {
  s.connection.close();
  s.flusher.close();
  s.transaction.open = s.transaction.started = false;
  s.claimed = 0;
}

Status open(Session& s, const char* conninfo, RecordMask watched, PostgresOptions options) {
  close(s);
  s.conninfo = {};
  s.conninfo.add(conninfo);
  if (s.conninfo.overflow()) return {StatusCode::capacity_exceeded, 1, max_conninfo_bytes};
  s.watched = watched;
  s.options = options;
  s.made_tables = false;
  const Status status = connect(s);
  if (!status.ok()) close(s);
  s.changes.changed = 0;
  return status;
}

Status connect(Session& s) {
  end_transaction(s);
  s.flusher.close();
  s.changes.received_others = true;
  s.awaited = {};
  s.answers.forget(~RecordMask{0});
  drop_held(s, ~RecordMask{0});
  s.capacity.used_is_known = false;
  ILP_TRY(s.connection.open(s.conninfo.c_str()));
  ILP_TRY(set_up(s));
  ILP_TRY(check_schema(s));
  return look(s);
}

Status send(Session& s, RowVerb verb, const RecordInfo& info, const Parameters& parameters, bool keep) {
  const std::size_t statement = static_cast<std::size_t>(info.type) * of_record + static_cast<std::size_t>(verb);
  if (!s.connection.prepared(statement)) ILP_TRY(prepare(s, statement, verb, info));
  return s.connection.send(statement, parameters, static_cast<std::int64_t>(info.type), keep);
}

Status send(Session& s, BlobVerb verb, const RecordInfo& info, std::size_t blob, const Parameters& parameters,
            bool keep) {
  const std::size_t statement =
      static_cast<std::size_t>(info.type) * of_record + row_verbs + blob * blob_verbs + static_cast<std::size_t>(verb);
  if (!s.connection.prepared(statement)) ILP_TRY(prepare(s, statement, verb, info, blob));
  return s.connection.send(statement, parameters, static_cast<std::int64_t>(info.type), keep);
}

Status send_special(Session& s, std::size_t which, void (*text)(SqlText&), const Parameters& parameters) {
  const std::size_t statement = first_special + which;
  if (!s.connection.prepared(statement)) ILP_TRY(prepare(s, statement, text));
  return s.connection.send(statement, parameters, 0, true);
}

Status send_look(Session& s) {
  s.awaited.look = s.connection.next_place();
  return send_special(s, 0, look_at_changes, {});
}

Status start(Session& s) {
  if (!s.transaction.open || s.transaction.started) return {};
  s.transaction.started = true;
  ILP_TRY(send_fixed(s, Fixed::begin));
  ILP_TRY(send_fixed(s, Fixed::lock));
  return send_look(s);
}

Status make_room(Session& s) {
  return s.connection.is_full() ? collect(s) : Status{};
}

Status collect(Session& s) {
  Status status = s.connection.collect();
  if (status.ok() && s.awaited.look != no_place) status = take_look(s);
  if (status.ok() && s.awaited.change != no_place) take_change(s);
  s.awaited.look = s.awaited.change = no_place;
  if (!status.ok() && s.transaction.open && s.transaction.doomed.ok()) s.transaction.doomed = status;
  return status;
}

Status begin(Session& s) {
  if (s.transaction.open) return out_of_range(Argument::transaction);
  if (!s.connection.alive()) return StatusCode::store_lost;
  s.transaction.open = true;
  return {};
}

Status commit(Session& s) {
  Status status = writable(s);
  if (status.ok()) status = send_latest_sizes(s);
  if (status.ok()) status = send_held_blob(s);
  if (status.ok() && s.transaction.uncommitted != 0) {
    s.awaited.change = s.connection.next_place();
    Parameters parameters;
    parameters.add(static_cast<std::int64_t>(s.transaction.uncommitted)).add(std::int64_t{s.options.notify ? 1 : 0});
    status = send_special(s, 1, note_changes, parameters);
  }
  if (status.ok() && s.transaction.started) status = send_commit(s);
  if (!status.ok()) {
    rollback(s);
    return status;
  }
  s.changes.changed |= s.transaction.uncommitted;
  end_transaction(s);
  return {};
}

void rollback(Session& s) {
  if (!s.transaction.open) return;
  s.answers.forget(s.transaction.touched);
  drop_held(s, s.transaction.touched);
  s.capacity.used_is_known = false;
  const bool started = s.transaction.started;
  end_transaction(s);
  if (!started || !s.connection.alive()) return;
  // Behind a failed statement the server takes nothing before the next collect().
  if (s.connection.anything_sent()) static_cast<void>(s.connection.collect());
  if (send_fixed(s, Fixed::rollback).ok()) static_cast<void>(s.connection.push());
}

Status writable(Session& s) {
  if (!s.transaction.open) return out_of_range(Argument::transaction);
  if (!s.connection.alive() && s.transaction.doomed.ok()) s.transaction.doomed = StatusCode::store_lost;
  return s.transaction.doomed;
}

Status written(Session& s, const RecordInfo& info, Status status) {
  s.transaction.touched |= mask_of(info.type);
  s.capacity.used_is_known = false;
  if (!status.ok()) {
    if (s.transaction.doomed.ok()) s.transaction.doomed = status;
    return status;
  }
  s.transaction.uncommitted |= mask_of(info.type);
  return {};
}

Status put(Session& s, const RecordInfo& info, const void* record) {
  ILP_TRY(writable(s));
  return written(s, info, put_record(s, info, record));
}

Status erase(Session& s, const RecordInfo& info, std::int64_t id) {
  ILP_TRY(writable(s));
  const Result<bool> there = erase_record(s, info, id);
  if (there.ok() && !there.value()) return {StatusCode::not_found, id};
  return written(s, info, there.status());
}

}  // namespace ilp::postgres
