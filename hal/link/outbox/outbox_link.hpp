// A link made of folders: it writes files into the outbox and reads confirmations from a second folder
// (docs/outbox.md).
#pragma once

#include "cfg/limits.hpp"
#include "hal/link/link.hpp"

namespace ilp {

class OutboxLink final : public Link {
 public:
  OutboxLink() = default;
  ~OutboxLink();

  /// Sets the folders, which must exist. Returns `io_error` (first value: errno) if one does not exist, and
  /// `capacity_exceeded` if a path exceeds limits::max_path_bytes.
  Status open(const char* outbox, const char* acknowledgements);

  Status begin_file(const char* name) override;
  Status write(std::span<const std::uint8_t> bytes) override;
  /// Synchronises the file to the disk and renames it, so that it appears complete or not at all. An error leaves
  /// nothing of the file in the outbox.
  Status end_file() override;
  /// Reads a confirmation of two numbers. Returns `not_ready` if there is none or it is incomplete, and `parse_error`
  /// if it is malformed. Sets `bytes` and `crc32` only when it returns ok.
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;

 private:
  /// Removes the file that was begun and not ended.
  void abandon();

  char outbox_[limits::max_path_bytes] = {};
  char acknowledgements_[limits::max_path_bytes] = {};
  char name_[limits::max_path_bytes] = {};
  int file_ = -1;
};

}  // namespace ilp
