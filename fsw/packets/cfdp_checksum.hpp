// Checksums of complete files (CCSDS 727.0-B-5, 4.2.2; SANA registry of CFDP checksum types).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/choices.hpp"

namespace ilp::cfdp {

/// Whether FileChecksum computes the checksum of this type.
[[nodiscard]] bool is_supported(std::uint8_t checksum_type);

/// Computes the checksum of a file that is added in order, in parts of any size.
class FileChecksum {
 public:
  FileChecksum() = default;
  explicit FileChecksum(ChecksumType type) : type_(type) {}

  void add(std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::uint32_t value() const { return value_; }
  /// Bytes added so far.
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  ChecksumType type_ = ChecksumType::null;
  std::uint32_t value_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace ilp::cfdp
