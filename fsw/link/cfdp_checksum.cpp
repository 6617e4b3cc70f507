#include "fsw/link/cfdp_checksum.hpp"

#include <array>

#include "fsw/base/crc.hpp"

namespace ilp::cfdp {
namespace {

constexpr std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t value = i;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) != 0 ? 0x82F63B78U : 0U);
    table[i] = value;
  }
  return table;
}
constexpr auto castagnoli = make_table();

std::uint32_t crc32c(std::span<const std::uint8_t> bytes, std::uint32_t crc) {
  std::uint32_t value = ~crc;
  for (const std::uint8_t byte : bytes) value = (value >> 8U) ^ castagnoli[(value ^ byte) & 0xFFU];
  return ~value;
}

/// `offset`: of the first byte in the file, for its place within a word.
std::uint32_t modular(std::span<const std::uint8_t> bytes, std::uint64_t offset, std::uint32_t sum) {
  for (const std::uint8_t byte : bytes) sum += std::uint32_t{byte} << (24U - 8U * static_cast<unsigned>(offset++ % 4));
  return sum;
}

}  // namespace

bool is_supported(std::uint8_t checksum_type) {
  switch (static_cast<ChecksumType>(checksum_type)) {
    case ChecksumType::modular:
    case ChecksumType::crc32c:
    case ChecksumType::crc32:
    case ChecksumType::null:
      return true;
  }
  return false;
}

void FileChecksum::add(std::span<const std::uint8_t> bytes) {
  switch (type_) {
    case ChecksumType::modular:
      value_ = modular(bytes, bytes_, value_);
      break;
    case ChecksumType::crc32c:
      value_ = crc32c(bytes, value_);
      break;
    case ChecksumType::crc32:
      value_ = crc32(bytes, value_);
      break;
    case ChecksumType::null:
      break;
  }
  bytes_ += bytes.size();
}

}  // namespace ilp::cfdp
