// A nonvolatile memory in two files that are written in turn.
#pragma once

#include <array>

#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

/// `PATH.keep-1` and `PATH.keep-2`. Each has a fixed size and holds its content twice, with a number that grows and a
/// checksum; the newest whole copy counts. A write goes over the older file, so that a torn one leaves the other; a
/// damaged octet spoils one copy of two. The files get all their room when they are made: a full disk stops no write.
class FileNonvolatile final : public Nonvolatile {
 public:
  FileNonvolatile() = default;
  FileNonvolatile(const FileNonvolatile&) = delete;
  FileNonvolatile& operator=(const FileNonvolatile&) = delete;
  ~FileNonvolatile() { close(); }

  /// Makes the files that are missing. `io_error` (a = errno): no file can be made or opened, or (a = EWOULDBLOCK)
  /// another process has them. Where it fails, reading and writing do too. On a disk for reading only they are read.
  Status open(const char* path);
  void close();

  Status read(std::span<std::uint8_t> content, std::size_t& bytes) override;
  Status write(std::span<const std::uint8_t> content) override;

 private:
  static constexpr std::size_t block_bytes = 8192;
  static constexpr std::size_t files = 2, copies = 2;
  using Block = std::array<std::uint8_t, block_bytes>;

  Status open_one(const char* path, std::size_t file);
  /// The whole copy of a file into `block_`; false where it has none.
  bool load(std::size_t file, std::uint64_t& number, std::size_t& bytes, bool& anything);

  std::array<int, files> files_{-1, -1};
  std::array<std::uint64_t, files> numbers_{};  ///< of what each file holds, 0: nothing whole
  bool known_ = false;                          ///< `numbers_` were read
  Block block_{};
};

}  // namespace ilp
