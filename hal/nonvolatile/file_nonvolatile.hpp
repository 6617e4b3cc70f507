// A nonvolatile memory in two files that are written in turn.
#pragma once

#include <array>

#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

/// The files are `PATH.keep-1` and `PATH.keep-2`. Each has a fixed size and holds its content twice, with a growing
/// number and a checksum; the newest whole copy counts. A write replaces the older file, so that an interrupted write
/// leaves the other one; a damaged octet spoils one of two copies. The files get their full size when they are made, so
/// that a full disk stops no write.
class FileNonvolatile final : public Nonvolatile {
 public:
  FileNonvolatile() = default;
  FileNonvolatile(const FileNonvolatile&) = delete;
  FileNonvolatile& operator=(const FileNonvolatile&) = delete;
  ~FileNonvolatile() { close(); }

  /// Makes the files that are missing. `io_error` (a = errno): no file can be made or opened, or (a = EWOULDBLOCK)
  /// another process has them; reading and writing then fail too. On a read-only disk the files are only read.
  Status open(const char* path);
  void close();

  Status read(std::span<std::uint8_t> content, std::size_t& bytes) override;
  Status write(std::span<const std::uint8_t> content) override;

 private:
  static constexpr std::size_t block_bytes = 8192;
  static constexpr std::size_t files = 2, copies = 2;
  using Block = std::array<std::uint8_t, block_bytes>;

  Status open_one(const char* path, std::size_t file);
  /// Loads the whole copy of a file into `block_`; false if it has none.
  bool load(std::size_t file, std::uint64_t& number, std::size_t& bytes, bool& anything);

  std::array<int, files> files_{-1, -1};
  std::array<std::uint64_t, files> numbers_{};  ///< number of each file's content; 0: no whole copy
  bool known_ = false;                          ///< `numbers_` were read
  Block block_{};
};

}  // namespace ilp
