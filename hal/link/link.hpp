// The link to the ground: whole files out, confirmations in.
#pragma once

#include <cstdint>
#include <span>

#include "fsw/base/status.hpp"

namespace ilp {

class Link {
 public:
  Link() = default;
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Comes before the transaction in which files are begun and ended: whatever takes long, and can be done before, is
  /// done here.
  virtual void prepare() {}
  /// A file becomes visible to the receiver only with end_file, as a whole. `not_ready` from any of the three: there is
  /// no contact, and the file must be begun again later. `transfer_queue_full` from begin_file: try again later.
  virtual Status begin_file(const char* name) = 0;
  virtual Status write(std::span<const std::uint8_t> bytes) = 0;
  virtual Status end_file() = 0;
  /// The size and CRC that the ground reports for this name; `not_ready` while it has reported nothing.
  virtual Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) = 0;
  /// Bytes of whole files that the link has taken and not sent yet; 0 for a link that sends a file as it takes it.
  virtual Status unsent(std::int64_t& bytes) {
    bytes = 0;
    return {};
  }

 protected:
  ~Link() = default;
};

}  // namespace ilp
