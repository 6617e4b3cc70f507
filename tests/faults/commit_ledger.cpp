#include "tests/faults/commit_ledger.hpp"

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "fsw/base/crc.hpp"
#include "hal/store/record_bytes.hpp"

namespace ilp::faults {
namespace {

/// Of every field; a blob counts by its size. Never 0.
std::uint32_t sum_of(const RecordInfo& info, const void* record) {
  std::uint32_t sum = 0;
  const auto* const bytes = static_cast<const std::uint8_t*>(record);
  for (std::size_t f = 0; f < info.field_count; ++f) {
    const FieldInfo& field = info.fields[f];
    std::size_t size = element_bytes(field.type) * field.count;
    // A NaN and a -0 may come back as others.
    if (field.type == FieldType::f32 || field.type == FieldType::f64) continue;
    if (field.type == FieldType::text) size = strnlen(reinterpret_cast<const char*>(bytes + field.offset), size);
    sum = crc32({bytes + field.offset, size}, sum);
  }
  return std::max(sum, 1U);
}

}  // namespace

CommitLedger::Entry& CommitLedger::entry(RecordType type, std::int64_t id) {
  for (std::size_t n = count_; n-- > 0;) {
    if (entries_[n].type == type && entries_[n].id == id) return entries_[n];
  }
  if (count_ == most_entries) throw std::runtime_error("the ledger is full");
  entries_[count_] = {type, id, 0, 0, false, false, false};
  return entries_[count_++];
}

void CommitLedger::write(RecordType type, std::int64_t id, std::uint32_t sum) {
  Entry& found = entry(type, id);
  found.next_sum = sum;
  found.open = found.in_transaction = true;
}

void CommitLedger::put(const RecordInfo& info, const void* record) {
  write(info.type, id_of(record), sum_of(info, record));
}

void CommitLedger::erase(const RecordInfo& info, std::int64_t id) {
  write(info.type, id, 0);
}

void CommitLedger::end(bool committed) {
  for (std::size_t n = 0; n < count_; ++n) {
    Entry& found = entries_[n];
    if (!found.in_transaction) continue;
    found.in_transaction = false;
    if (!committed) continue;
    found.sum = found.next_sum;
    found.open = false;
    found.reported = true;
  }
}

int CommitLedger::missing(Store& store, std::int64_t& type, std::int64_t& id) const {
  int count = 0;
  for (std::size_t n = 0; n < count_; ++n) {
    const Entry& wanted = entries_[n];
    if (!wanted.reported) continue;
    const RecordInfo& info = record_info(wanted.type);
    alignas(8) std::byte record[limits::max_record_bytes]{};
    const Status status = store.get(info, wanted.id, record);
    const std::uint32_t found = status.ok() ? sum_of(info, record) : 0;
    if (status.ok() || status.is(StatusCode::not_found)) {
      if (found == wanted.sum || (wanted.open && found == wanted.next_sum)) continue;
    }
    if (count++ > 0) continue;
    type = static_cast<std::int64_t>(wanted.type);
    id = wanted.id;
  }
  return count;
}

Status LedgerStore::commit() {
  const Status status = inner_.commit();
  ledger_.end(status.ok());
  return status;
}

void LedgerStore::rollback() {
  inner_.rollback();
  ledger_.end(false);
}

Status LedgerStore::put(const RecordInfo& info, const void* record) {
  ledger_.put(info, record);
  return inner_.put(info, record);
}

Status LedgerStore::erase(const RecordInfo& info, std::int64_t id) {
  ledger_.erase(info, id);
  return inner_.erase(info, id);
}

}  // namespace ilp::faults
