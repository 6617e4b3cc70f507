#include "fsw/shared/flight_memory.hpp"

#include <cstring>
#include <type_traits>

#include "fsw/base/crc.hpp"

namespace ilp {
namespace {

constexpr std::int64_t transactions_per_block = 64;
constexpr std::int64_t most_store_epochs = 1'000'000'000;
constexpr std::int64_t most_base = 1'000'000'000'000'000;
constexpr std::int64_t most_id = std::int64_t{1} << 62U;
constexpr double most_epoch_s = 6e9;

std::span<const std::uint8_t> octets(const FlightMemoryContent& content) {
  static_assert(std::is_trivially_copyable_v<FlightMemoryContent>);
  return {reinterpret_cast<const std::uint8_t*>(&content), sizeof(content)};
}

}  // namespace

const KeptSetting* KeptSettings::find(std::uint64_t number) const {
  for (std::size_t i = 0; i < count; ++i) {
    if (items[i].number == number) return &items[i];
  }
  return nullptr;
}

bool KeptSettings::set(std::uint64_t number, double value) {
  for (std::size_t i = 0; i < count; ++i) {
    if (items[i].number != number) continue;
    items[i].value = value;
    return true;
  }
  if (count == capacity) return false;
  items[count++] = {number, value};
  return true;
}

void KeptSettings::remove(std::uint64_t number) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (items[i].number != number) items[kept++] = items[i];
  }
  for (std::size_t i = kept; i < count; ++i) items[i] = {};
  count = kept;
}

bool FlightMemory::valid(const FlightMemoryContent& content) {
  // A checksum shows that the bytes are as written, not that the values are valid.
  const auto count = [](std::int64_t value, std::int64_t most) { return value >= 0 && value <= most; };
  if (!count(content.life, most_store_epochs) || !count(content.keyframe_base, most_base) ||
      !count(content.record_base, most_base) || !count(content.transactions_reserved, most_id) ||
      !count(content.configuration, most_id) || !count(content.latest_ns, most_id) ||
      !count(content.tentative_ns, most_id) ||
      !(content.mission_epoch_s >= 0 && content.mission_epoch_s <= most_epoch_s)) {
    return false;
  }
  return content.layout == FlightMemoryContent::current_layout && content.good.count <= KeptSettings::capacity &&
         content.wanted.count <= KeptSettings::capacity;
}

void FlightMemory::seal() {
  crc_ = crc32(octets(content_));
  sealed_ = true;
}

Status FlightMemory::load() {
  content_ = {};
  FlightMemoryContent read;
  std::size_t bytes = 0;
  Status status = medium_.read({reinterpret_cast<std::uint8_t*>(&read), sizeof(read)}, bytes);
  if (status.ok() && (bytes != sizeof(read) || !valid(read))) status = {StatusCode::record_damaged, 0, read.layout};
  if (status.ok()) content_ = read;
  transactions_used_ = content_.transactions_reserved;
  seal();
  return status;
}

const FlightMemoryContent& FlightMemory::content() {
  if (!sealed_) seal();
  if (crc32(octets(content_)) != crc_) static_cast<void>(load());
  return content_;
}

Status FlightMemory::keep(const FlightMemoryContent& content) {
  content_ = content;
  seal();
  kept_ = medium_.write(octets(content_));
  return kept_;
}

std::int64_t FlightMemory::next_transaction(std::int64_t latest) {
  if (latest > transactions_used_) transactions_used_ = latest;
  const std::int64_t number = ++transactions_used_;
  if (number > content().transactions_reserved) {
    FlightMemoryContent after = content();
    after.transactions_reserved = number + transactions_per_block - 1;
    // If that fails the store still has the number, with the transaction that uses it.
    static_cast<void>(keep(after));
  }
  return number;
}

void FlightMemory::skip_transactions(std::int64_t through) {
  if (through > transactions_used_) transactions_used_ = through;
}

}  // namespace ilp
