// Interface of a nonvolatile memory of a few thousand octets, for data that must survive the loss of the database.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr std::size_t max_nonvolatile_bytes = 8000;

/// Holds one content of up to max_nonvolatile_bytes. After an interrupted write, read() returns the previous content.
/// Reading and writing take a fixed amount of memory.
class Nonvolatile {
 public:
  /// Reads the latest content into the first `bytes` octets of `content`. Returns `not_found` if nothing was ever
  /// written, `record_damaged` if every written copy is damaged, `capacity_exceeded` (first value: size of the content)
  /// if `content` is too small, `io_error` (first value: errno) if the medium cannot be read.
  virtual Status read(std::span<std::uint8_t> content, std::size_t& bytes) = 0;
  /// Replaces the content, which is on the medium when the call returns ok. Returns `capacity_exceeded` if the content
  /// is larger than max_nonvolatile_bytes, `io_error` (first value: errno) if the medium cannot be written.
  virtual Status write(std::span<const std::uint8_t> content) = 0;

 protected:
  ~Nonvolatile() = default;
};

}  // namespace ilp
