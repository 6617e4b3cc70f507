#include "sim/sil/stall_guard.hpp"

#include "fsw/base/rng.hpp"
#include "hal/store/record_bytes.hpp"

namespace ilp::sil {
namespace {

std::uint64_t fingerprint_of(Store& store) {
  std::uint64_t hash = 0;
  const auto add = [&hash](std::int64_t value) { hash = mix64(hash ^ static_cast<std::uint64_t>(value)); };
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if ((mask_of(type) & mask_of(RecordType::event, RecordType::component, RecordType::timing)) != 0) continue;
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    add(store.last(record_info(type), record).ok() ? id_of(record) : 0);
  }
  CheckpointRecord checkpoint;
  for (std::int64_t id = 0; next(store, id, checkpoint).ok(); id = checkpoint.id) {
    add(checkpoint.cursor);
    add(checkpoint.cursor_second);
  }
  return hash;
}

}  // namespace

bool StallGuard::stalled(Store& store, TimeNs now) {
  const std::uint64_t fingerprint = fingerprint_of(store);
  if (changed_ns_ < 0 || fingerprint != fingerprint_) changed_ns_ = now;
  fingerprint_ = fingerprint;
  return now - changed_ns_ > longest_;
}

}  // namespace ilp::sil
