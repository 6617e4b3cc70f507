// A link made of folders: files appear in the outbox, confirmations in a folder of their own (docs/outbox.md).
#pragma once

#include "cfg/limits.hpp"
#include "hal/link/link.hpp"

namespace ilp {

class OutboxLink final : public Link {
 public:
  OutboxLink() = default;
  ~OutboxLink();

  /// Both folders must exist. `capacity_exceeded` for paths beyond limits::max_path_bytes.
  Status open(const char* outbox, const char* acknowledgements);

  Status begin_file(const char* name) override;
  Status write(std::span<const std::uint8_t> bytes) override;
  /// The file is synchronised to the disk and renamed, so that it appears whole or not at all. After a fault nothing is
  /// left in the outbox.
  Status end_file() override;
  /// `parse_error` for a confirmation that is not two numbers; an incomplete one is `not_ready`. Bytes and CRC are set
  /// only when ok.
  Status acknowledged(const char* name, std::uint32_t& bytes, std::uint32_t& crc32) override;

 private:
  void abandon();

  char outbox_[limits::max_path_bytes] = {};
  char acknowledgements_[limits::max_path_bytes] = {};
  char name_[limits::max_path_bytes] = {};
  int file_ = -1;
};

}  // namespace ilp
