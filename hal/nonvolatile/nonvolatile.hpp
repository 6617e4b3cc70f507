// A few thousand octets that outlive the database, for data that must not be lost with it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

inline constexpr std::size_t max_nonvolatile_bytes = 8000;

/// Holds one content as a whole: after an interrupted write the previous content is read. Reading and writing are
/// bounded in memory.
class Nonvolatile {
 public:
  /// Reads the latest content. `not_found`: nothing was ever written; `record_damaged`: there is no whole copy of what
  /// was written; `io_error` (a = errno).
  virtual Status read(std::span<std::uint8_t> content, std::size_t& bytes) = 0;
  /// The content is on the medium when it returns ok. `io_error` (a = errno), `capacity_exceeded`.
  virtual Status write(std::span<const std::uint8_t> content) = 0;

 protected:
  ~Nonvolatile() = default;
};

}  // namespace ilp
