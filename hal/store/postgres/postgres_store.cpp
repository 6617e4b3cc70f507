#include "hal/store/postgres/postgres_store.hpp"

#include "fsw/base/argument.hpp"
#include "fsw/records/records.hpp"
#include "hal/store/postgres/columns.hpp"
#include "hal/store/postgres/settings.hpp"

namespace ilp {

using namespace postgres;

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

}  // namespace

void PostgresStore::close() {
  connection_.close();
  flusher_.close();
  in_transaction_ = started_ = false;
  claimed_ = 0;
}

Status PostgresStore::open(const char* conninfo, RecordMask watched, PostgresOptions options) {
  close();
  conninfo_ = {};
  conninfo_.add(conninfo);
  if (conninfo_.overflow()) return {StatusCode::capacity_exceeded, 1, max_conninfo_bytes};
  watched_ = watched;
  options_ = options;
  made_tables_ = false;
  const Status status = connect();
  if (!status.ok()) close();
  changed_ = 0;
  return status;
}

Status PostgresStore::connect() {
  end_transaction();
  flusher_.close();
  heard_others_ = true;
  awaited_ = {};
  answers_.forget(~RecordMask{0});
  drop_held(~RecordMask{0});
  used_is_known_ = false;
  ILP_TRY(connection_.open(conninfo_.c_str()));
  ILP_TRY(set_up());
  ILP_TRY(check_schema());
  return look();
}

Status PostgresStore::set_up() {
  for (const char* setting : session_settings) ILP_TRY(connection_.send(setting, false));
  ILP_TRY(connection_.send("LISTEN ilp", false));
  return connection_.collect();
}

Status PostgresStore::integer_of(const char* sql, std::int64_t& value) {
  ILP_TRY(connection_.send(sql, true));
  ILP_TRY(connection_.collect());
  return connection_.rows(0).number(0, 0, value) ? Status{} : Status{StatusCode::store_damaged};
}

/// Functions that look a name up, such as to_regclass, may answer what was true before this process waited for the
/// lock.
Result<bool> PostgresStore::has_tables() {
  std::int64_t found = 0;
  ILP_TRY(integer_of("SELECT count(*) FROM pg_class WHERE relname='ilp_store' AND pg_table_is_visible(oid)", found));
  return found != 0;
}

Status PostgresStore::check_schema() {
  if (!connection_.texts_are_bytes()) return {StatusCode::store_schema, -1, schema_fingerprint()};
  ILP_TAKE(const bool there, has_tables());
  if (!there && !options_.create) return StatusCode::not_found;
  if (!there) ILP_TRY(create_schema());
  std::int64_t fingerprint = 0;
  ILP_TRY(integer_of("SELECT fingerprint FROM ilp_store", fingerprint));
  return fingerprint == schema_fingerprint() ? Status{}
                                             : Status{StatusCode::store_schema, fingerprint, schema_fingerprint()};
}

/// One transaction: the server may end between any two statements, and another process may do the same.
Status PostgresStore::create_schema() {
  ILP_TRY(send_fixed(Fixed::begin));
  ILP_TRY(send_fixed(Fixed::lock));
  ILP_TAKE(const bool there, has_tables());
  SqlText sql;
  const auto send_text = [&] {
    const Status status = connection_.send(sql.c_str(), false);
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
  ILP_TRY(send_fixed(Fixed::commit));
  ILP_TRY(send_fixed(Fixed::flush));
  made_tables_ = !there;
  return connection_.collect();
}

/// Of its own, so that the text is not on the stack beside the parameters; the others likewise.
[[gnu::noinline]] Status PostgresStore::prepare(std::size_t statement, RowVerb verb, const RecordInfo& info) {
  const auto table = static_cast<std::int64_t>(info.type);
  SqlText sql;
  row_statement(verb, info, sql);
  ILP_ASSERT(!sql.overflow(), table);
  return connection_.prepare(statement, sql.c_str(), table);
}

Status PostgresStore::send(RowVerb verb, const RecordInfo& info, const Parameters& parameters, bool keep) {
  const std::size_t statement = static_cast<std::size_t>(info.type) * of_record + static_cast<std::size_t>(verb);
  if (!connection_.prepared(statement)) ILP_TRY(prepare(statement, verb, info));
  return connection_.send(statement, parameters, static_cast<std::int64_t>(info.type), keep);
}

[[gnu::noinline]] Status PostgresStore::prepare(std::size_t statement, BlobVerb verb, const RecordInfo& info,
                                                std::size_t blob) {
  SqlText sql;
  blob_statement(verb, info, blob_field(info, blob), sql);
  return connection_.prepare(statement, sql.c_str(), static_cast<std::int64_t>(info.type));
}

Status PostgresStore::send(BlobVerb verb, const RecordInfo& info, std::size_t blob, const Parameters& parameters,
                           bool keep) {
  const std::size_t statement =
      static_cast<std::size_t>(info.type) * of_record + row_verbs + blob * blob_verbs + static_cast<std::size_t>(verb);
  if (!connection_.prepared(statement)) ILP_TRY(prepare(statement, verb, info, blob));
  return connection_.send(statement, parameters, static_cast<std::int64_t>(info.type), keep);
}

[[gnu::noinline]] Status PostgresStore::prepare(std::size_t statement, void (*text)(SqlText&)) {
  SqlText sql;
  text(sql);
  ILP_ASSERT(!sql.overflow(), statement);
  return connection_.prepare(statement, sql.c_str(), 0);
}

Status PostgresStore::send_special(std::size_t which, void (*text)(SqlText&), const Parameters& parameters) {
  const std::size_t statement = first_special + which;
  if (!connection_.prepared(statement)) ILP_TRY(prepare(statement, text));
  return connection_.send(statement, parameters, 0, true);
}

Status PostgresStore::send_look() {
  awaited_.look = connection_.next_place();
  return send_special(0, look_at_changes, {});
}

Status PostgresStore::send_fixed(Fixed which) {
  static constexpr const char* texts[] = {begin_statement, lock_statement, commit_statement, rollback_statement,
                                          flush_statement};
  const std::size_t statement = first_fixed + static_cast<std::size_t>(which);
  if (!connection_.prepared(statement)) {
    ILP_TRY(connection_.prepare(statement, texts[static_cast<std::size_t>(which)], 0));
  }
  return connection_.send(statement, {}, 0, false);
}

Status PostgresStore::start() {
  if (!in_transaction_ || started_) return {};
  started_ = true;
  ILP_TRY(send_fixed(Fixed::begin));
  ILP_TRY(send_fixed(Fixed::lock));
  ILP_TRY(send_look());
  if (early_.empty()) return {};
  ILP_TRY(collect());
  return check_early_reads();
}

/// Asks again what may have changed.
Status PostgresStore::check_early_reads() {
  for (std::size_t i = 0; i < early_.size(); ++i) {
    const Asked asked = early_[i].asked;
    if ((changed_early_ & mask_of(asked.type)) == 0) continue;
    const RecordInfo& info = record_info(asked.type);
    alignas(8) std::uint8_t record[limits::max_record_bytes];
    const Status found = read_granted(asked, rows_of_a_question, record);
    if (!found.ok() && !found.is(StatusCode::not_found)) return found;
    if (EarlyReads::check_of(info, found.ok() ? record : nullptr) == early_[i].check) continue;
    doomed_ = {StatusCode::store_error, changed_meanwhile, static_cast<std::int64_t>(asked.type)};
    return doomed_;
  }
  return {};
}

/// The queue of statements without an answer is finite.
Status PostgresStore::make_room() {
  return connection_.is_full() ? collect() : Status{};
}

Status PostgresStore::collect() {
  Status status = connection_.collect();
  if (status.ok() && awaited_.look != none) status = take_look();
  if (status.ok() && awaited_.change != none) take_change();
  awaited_.look = awaited_.change = none;
  if (!status.ok() && in_transaction_ && doomed_.ok()) doomed_ = status;
  return status;
}

Status PostgresStore::begin() {
  if (in_transaction_) return out_of_range(Argument::transaction);
  if (!connected()) return StatusCode::store_lost;
  in_transaction_ = true;
  guesses_.begin_transaction();
  return {};
}

void PostgresStore::end_transaction() {
  in_transaction_ = started_ = false;
  doomed_ = {};
  uncommitted_ = touched_ = 0;
  latest_ = {};
  awaited_ = {};
  early_.clear();
  changed_early_ = 0;
}

/// The transaction ends, the others are notified and may begin theirs, while this process waits until its changes are
/// on the server's disk. What they commit then comes behind it in the server's log, so none of it outlasts this one.
Status PostgresStore::send_commit() {
  const bool changes = uncommitted_ != 0;
  const std::size_t change = awaited_.change;
  ILP_TRY(send_fixed(Fixed::commit));
  if (changes && options_.synchronous) ILP_TRY(send_fixed(Fixed::flush));
  const Status status = collect();
  const bool may_be_carried_out = changes && connected() && connection_.rows(change).count() != 0;
  if (status.ok() || !may_be_carried_out) return status;
  connection_.close();
  return {StatusCode::store_lost, status.a};
}

Status PostgresStore::commit() {
  Status status = writable();
  if (status.ok()) status = send_latest_sizes();
  if (status.ok()) status = send_held_blob();
  if (status.ok() && uncommitted_ != 0) {
    awaited_.change = connection_.next_place();
    Parameters parameters;
    parameters.add(static_cast<std::int64_t>(uncommitted_)).add(std::int64_t{options_.notify ? 1 : 0});
    status = send_special(1, postgres::note_changes, parameters);
  }
  if (status.ok() && started_) status = send_commit();
  if (!status.ok()) {
    rollback();
    return status;
  }
  changed_ |= uncommitted_;
  end_transaction();
  return {};
}

void PostgresStore::rollback() {
  if (!in_transaction_) return;
  answers_.forget(touched_);
  drop_held(touched_);
  used_is_known_ = false;
  const bool started = started_;
  end_transaction();
  if (!started || !connected()) return;
  // Behind a failed statement the server takes nothing before the next collect().
  if (connection_.anything_sent()) static_cast<void>(connection_.collect());
  if (send_fixed(Fixed::rollback).ok()) static_cast<void>(connection_.push());
}

Status PostgresStore::writable() {
  if (!in_transaction_) return out_of_range(Argument::transaction);
  if (!connected() && doomed_.ok()) doomed_ = StatusCode::store_lost;
  return doomed_;
}

Status PostgresStore::written(const RecordInfo& info, Status status) {
  touched_ |= mask_of(info.type);
  used_is_known_ = false;
  if (!status.ok()) {
    if (doomed_.ok()) doomed_ = status;
    return status;
  }
  uncommitted_ |= mask_of(info.type);
  return {};
}

/// Counts what the store would grow by, at most. Only where that goes beyond the limit it is asked what there is.
Status PostgresStore::check_limit(const RecordInfo& info, const void* record) {
  std::int64_t bytes = 0;
  bool fits = true;
  for_each_blob(info, [&](const FieldInfo& field, std::size_t) {
    bytes += blob_bytes(record, field);
    fits = fits && blob_bytes(record, field) <= max_postgres_blob_bytes;
  });
  if (!fits) return {StatusCode::capacity_exceeded, bytes, max_postgres_blob_bytes};
  asked_bytes_ += bytes;
  if (bytes == 0 || limit_bytes_ == 0) return {};
  // Others put as well: eight processes together do not go beyond the limit.
  if (used_ms_ >= 0 && asked_bytes_ <= (limit_bytes_ - used_bytes_) / 8) return {};
  std::int64_t before = 0;
  ILP_TRY(read_used_bytes(used_bytes_));
  used_ms_ = steady_ms();
  ILP_TRY(read_blob_sizes(info, id_of(record), before));
  asked_bytes_ = bytes - before;
  if (used_bytes_ + asked_bytes_ <= limit_bytes_) return {};
  return {StatusCode::store_full, used_bytes_, limit_bytes_};
}

Status PostgresStore::send_put(const RecordInfo& info, const void* record) {
  Parameters parameters;
  bind_record(info, record, parameters);
  return send(RowVerb::put, info, parameters, false);
}

Status PostgresStore::put_record(const RecordInfo& info, const void* record) {
  ILP_TRY(check_limit(info, record));
  ILP_TRY(send_latest_sizes());
  ILP_TRY(send_held_blob());
  ILP_TRY(start());
  ILP_TRY(make_room());
  ILP_TRY(send_put(info, record));
  latest_ = {&info, id_of(record), {}, {}};
  for_each_blob(info, [&](const FieldInfo& field, std::size_t index) {
    latest_.bytes[index] = blob_bytes(record, field);
    HeldBlob* const held = find_held({info.type, index, id_of(record), 0});
    if (held != nullptr && held->name.bytes != latest_.bytes[index]) held->forget();
  });
  alignas(8) std::uint8_t as_read[limits::max_record_bytes];
  canonical_record(info, record, as_read);
  answers_.put(info, as_read);
  return {};
}

Status PostgresStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(writable());
  return written(info, put_record(info, record));
}

Result<bool> PostgresStore::erase_record(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(send_latest_sizes());
  ILP_TRY(send_held_blob());
  ILP_TRY(start());
  ILP_TRY(make_room());
  drop_held_of(info.type, id);
  if (latest_.info == &info && latest_.id == id) latest_ = {};
  Parameters parameters;
  parameters.add(id);
  Status status;
  for_each_blob(info, [&](const FieldInfo&, std::size_t blob) {
    if (status.ok()) status = send(BlobVerb::erase, info, blob, parameters, false);
  });
  ILP_TRY(status);
  AnswerCache::Answer answer;
  ILP_TRY(send(RowVerb::erase, info, parameters, false));
  bool there = awaited_.look == none && answers_.find(info, Question::get, id, answer) && answer.found;
  if (!there) {
    ILP_TRY(collect());
    there = connection_.rows_changed() != 0;
  }
  answers_.erase(info, id);
  return there;
}

Status PostgresStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(writable());
  const Result<bool> there = erase_record(info, id);
  if (there.ok() && !there.value()) return {StatusCode::not_found, id};
  return written(info, there.status());
}

}  // namespace ilp
