#include "sim/sil/faulty_store.hpp"

namespace ilp::sil {

FaultyStore::FaultyStore(Store& store, Clock& clock, const FaultWindow& full)
    : ForwardingStore(store), clock_(clock), full_(full) {}

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
  const std::int64_t bytes = inner_.usage().bytes;
  doomed_ = {StatusCode::store_full, bytes, bytes};
  return doomed_;
}

Status FaultyStore::begin() {
  doomed_ = {};
  return inner_.begin();
}

Status FaultyStore::commit() {
  meet_power_cut();
  if (doomed_.ok()) return inner_.commit();
  const Status status = doomed_;
  rollback();
  return status;
}

void FaultyStore::rollback() {
  doomed_ = {};
  inner_.rollback();
}

Status FaultyStore::put(const RecordInfo& info, const void* record) {
  ILP_TRY(admit());
  return inner_.put(info, record);
}

Status FaultyStore::erase(const RecordInfo& info, std::int64_t id) {
  ILP_TRY(admit());
  return inner_.erase(info, id);
}

Status FaultyStore::write_blob(const RecordInfo& info, const char* field, std::int64_t id, std::size_t offset,
                               std::span<const std::uint8_t> bytes) {
  ILP_TRY(admit());
  return inner_.write_blob(info, field, id, offset, bytes);
}

}  // namespace ilp::sil
