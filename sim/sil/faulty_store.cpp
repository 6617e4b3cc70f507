#include "sim/sil/faulty_store.hpp"

namespace ilp::sim {

FaultyStore::FaultyStore(Store& store, Clock& clock, const FaultWindow& full)
    : store_(store), clock_(clock), full_(full) {}

void FaultyStore::cut_at_write(std::int64_t writes_from_now, std::function<void()> cut) {
  writes_until_cut_ = writes_from_now;
  cut_ = std::move(cut);
}

void FaultyStore::meet_power_cut() {
  if (writes_until_cut_ < 0) return;
  if (writes_until_cut_-- == 0) cut_();
}

Status FaultyStore::admit() {
  meet_power_cut();
  if (!doomed_.ok()) return doomed_;
  if (!inside_window(clock_.now(), full_)) return {};
  ++refused_;
  const std::int64_t bytes = store_.usage().bytes;
  doomed_ = {StatusCode::store_full, bytes, bytes};
  return doomed_;
}

Status FaultyStore::begin() {
  doomed_ = {};
  return store_.begin();
}

Status FaultyStore::commit() {
  meet_power_cut();
  if (doomed_.ok()) return store_.commit();
  const Status status = doomed_;
  rollback();
  return status;
}

void FaultyStore::rollback() {
  doomed_ = {};
  store_.rollback();
}

Status FaultyStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(admit());
  return store_.put(info, record);
}

Status FaultyStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(admit());
  return store_.erase(info, id);
}

Status FaultyStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                               std::span<const std::uint8_t> bytes) {
  ILP_TRY(admit());
  return store_.write_blob(info, field, id, offset, bytes);
}

Status FaultyStore::get(const RecordInfo& info, std::int64_t id, void* record) {
  return store_.get(info, id, record);
}

Status FaultyStore::next(const RecordInfo& info, std::int64_t after, void* record) {
  return store_.next(info, after, record);
}

Status FaultyStore::last(const RecordInfo& info, void* record) {
  return store_.last(info, record);
}

Status FaultyStore::count(const RecordInfo& info, std::int64_t& records) {
  return store_.count(info, records);
}

Status FaultyStore::read_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                              std::span<std::uint8_t> bytes) {
  return store_.read_blob(info, field, id, offset, bytes);
}

Status FaultyStore::poll(RecordMask& changed) {
  return store_.poll(changed);
}

StoreUsage FaultyStore::usage() {
  return store_.usage();
}

}  // namespace ilp::sim
