// The way to the ground: whole files out, confirmations in.
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

  /// A file becomes visible to the receiver only with end_file, whole. `not_ready` from any of the three: there is no
  /// contact, the file is given up and has to be begun again later. `transfer_queue_full` from begin_file: not now.
  virtual Status begin_file(const char* name) = 0;
  virtual Status write(std::span<const std::uint8_t> bytes) = 0;
  virtual Status end_file() = 0;
  /// What the ground says it holds under this name; `not_ready` when it has said nothing yet.
  virtual Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) = 0;

 protected:
  ~Link() = default;
};

}  // namespace ilp
