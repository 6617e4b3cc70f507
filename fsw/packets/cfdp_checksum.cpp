#include "fsw/packets/cfdp_checksum.hpp"

#include "fsw/base/crc.hpp"

namespace ilp::cfdp {
namespace {

/// `offset` is that of the first byte in the file, which gives its place within a word.
std::uint32_t modular(std::span<const std::uint8_t> bytes, std::uint64_t offset, std::uint32_t sum) {
  for (const std::uint8_t byte : bytes) sum += std::uint32_t{byte} << (24U - 8U * static_cast<unsigned>(offset++ % 4));
  return sum;
}

}  // namespace

bool is_supported(std::uint8_t checksum_type) {
  return find_value(ChecksumType_values, checksum_type) != nullptr;
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
    case ChecksumType::count:
      break;
  }
  bytes_ += bytes.size();
}

}  // namespace ilp::cfdp
