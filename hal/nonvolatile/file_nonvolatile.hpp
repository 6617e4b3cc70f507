// A nonvolatile memory in two files that write() replaces in turn.
#pragma once

#include <array>

#include "hal/nonvolatile/nonvolatile.hpp"

namespace ilp {

/// The files are `PATH.keep-1` and `PATH.keep-2`. Each file has a fixed size and holds two copies of its content. A
/// copy has a checksum and a number that grows with each write; read() returns the undamaged copy with the highest
/// number. A write replaces the older file, so that an interrupted write leaves the newer one. A damaged octet damages
/// only one copy. The files get their full size when they are made, so that writes succeed on a full disk.
class FileNonvolatile final : public Nonvolatile {
 public:
  FileNonvolatile() = default;
  FileNonvolatile(const FileNonvolatile&) = delete;
  FileNonvolatile& operator=(const FileNonvolatile&) = delete;
  ~FileNonvolatile() { close(); }

  /// Opens the files and makes missing ones. Returns `io_error` (first value: errno) if a file cannot be made or
  /// opened, or (EWOULDBLOCK) if another process has locked it; reading and writing then fail too. Returns
  /// `capacity_exceeded` if the path is too long. On a read-only disk the files can only be read.
  Status open(const char* path);
  void close();

  Status read(std::span<std::uint8_t> content, std::size_t& bytes) override;
  Status write(std::span<const std::uint8_t> content) override;

 private:
  static constexpr std::size_t block_bytes = 8192;
  static constexpr std::size_t files = 2, copies = 2;
  using Block = std::array<std::uint8_t, block_bytes>;

  Status open_one(const char* path, std::size_t file);
  /// Loads the first undamaged copy of a file into `block_`; false if there is none. Sets `anything` if a copy has an
  /// octet that is not 0.
  bool load(std::size_t file, std::uint64_t& number, std::size_t& bytes, bool& anything);

  std::array<int, files> files_{-1, -1};
  std::array<std::uint64_t, files> numbers_{};  ///< number of each file's content; 0: no undamaged copy
  bool known_ = false;                          ///< `numbers_` are those of the files
  Block block_{};
};

}  // namespace ilp
