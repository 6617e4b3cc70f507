// Reads a file descriptor byte by byte through a fixed buffer.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/posix/file.hpp"

namespace ilp {

class BufferedReader {
 public:
  /// Takes a descriptor, which stays the caller's.
  void attach(int file) {
    file_ = file;
    begin_ = 0;
    end_ = 0;
    total_ = 0;
  }
  /// `end_of_stream` (a = bytes read so far) after the last byte.
  Status next(std::uint8_t& byte) {
    if (begin_ == end_) {
      begin_ = 0;
      ILP_TRY(read_some(file_, buffer_, end_));
      if (end_ == 0) return {StatusCode::end_of_stream, total_};
    }
    byte = buffer_[begin_++];
    ++total_;
    return {};
  }
  /// Reads all of `bytes`, or returns `truncated` (a = bytes read, b = bytes wanted).
  Status fill(std::span<std::uint8_t> bytes) {
    std::size_t got = 0;
    while (got < bytes.size() && begin_ < end_) bytes[got++] = buffer_[begin_++];
    std::size_t more = 0;
    ILP_TRY(read_some(file_, bytes.subspan(got), more));
    got += more;
    total_ += static_cast<std::int64_t>(got);
    if (got == bytes.size()) return {};
    return {StatusCode::truncated, static_cast<std::int64_t>(got), static_cast<std::int64_t>(bytes.size())};
  }

 private:
  int file_ = -1;
  std::array<std::uint8_t, 4096> buffer_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::int64_t total_ = 0;
};

}  // namespace ilp
