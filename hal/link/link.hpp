// Interface of the link that sends complete files to the ground and reports which of them the ground has received.
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

  /// Called before the transaction in which files are begun and ended, for work that takes long and may precede the
  /// transaction.
  virtual void prepare() {}
  /// Begins a file, which replaces an unfinished one. The receiver sees a file only after end_file(), and then
  /// complete. begin_file(), write() and end_file() return `not_ready` if there is no contact; the caller must then
  /// begin the file again later. begin_file() returns `transfer_queue_full` if the caller must try again later.
  virtual Status begin_file(const char* name) = 0;
  virtual Status write(std::span<const std::uint8_t> bytes) = 0;
  virtual Status end_file() = 0;
  /// Reads the size and the CRC-32 of this file that the ground has confirmed. Returns `not_ready` while there is no
  /// confirmation.
  virtual Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) = 0;
  /// Bytes of ended files that the link has not sent yet; 0 for a link that sends each file in end_file().
  virtual Status unsent(std::int64_t& bytes) {
    bytes = 0;
    return {};
  }

 protected:
  ~Link() = default;
};

}  // namespace ilp
