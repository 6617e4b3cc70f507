// Reads a file descriptor byte by byte through a fixed buffer.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/posix/file.hpp"

namespace ilp {

class BufferedReader {
 public:
  /// Begins to read a descriptor. The caller closes it.
  void attach(int file) {
    file_ = file;
    begin_ = 0;
    end_ = 0;
    total_ = 0;
    live_ = false;
  }
  /// Limits how long reads wait for bytes: `waits` times in total until the next call of allow_waits(), `wait_ms` each
  /// time. After that they return `not_ready`. Without such a call after attach(), reads wait without limit.
  void allow_waits(int waits, int wait_ms) {
    live_ = true;
    waits_ = waits;
    wait_ms_ = wait_ms;
  }
  /// Reads one byte. Returns `end_of_stream` (first value: bytes read since attach()) after the last byte.
  Status next(std::uint8_t& byte) {
    if (begin_ == end_) {
      ILP_TRY(await());
      begin_ = 0;
      ILP_TRY(live_ ? read_once(file_, buffer_, end_) : read_some(file_, buffer_, end_));
      if (end_ == 0) return {StatusCode::end_of_stream, total_};
    }
    byte = buffer_[begin_++];
    ++total_;
    return {};
  }
  /// Fills `bytes` from index `got` on and advances `got`. Returns `truncated` (first value: `got`, second: size of
  /// `bytes`) if the file ends earlier. After `not_ready`, a call with the same arguments continues.
  Status fill(std::span<std::uint8_t> bytes, std::size_t& got) {
    while (got < bytes.size()) {
      std::size_t more = std::min(end_ - begin_, bytes.size() - got);
      std::copy_n(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), more,
                  bytes.begin() + static_cast<std::ptrdiff_t>(got));
      begin_ += more;
      if (more == 0) {
        ILP_TRY(await());
        ILP_TRY(read_once(file_, bytes.subspan(got), more));
        if (more == 0) {
          return {StatusCode::truncated, static_cast<std::int64_t>(got), static_cast<std::int64_t>(bytes.size())};
        }
      }
      got += more;
      total_ += static_cast<std::int64_t>(more);
    }
    return {};
  }
  /// Fills `bytes` from its beginning.
  Status fill(std::span<std::uint8_t> bytes) {
    std::size_t got = 0;
    return fill(bytes, got);
  }
  /// Reads the next line of a text, `size` octets, into `text`, with a terminator in place of the newline. The last
  /// line may lack its newline. Returns `end_of_stream` if no byte is left, and `parse_error` (first value: size of
  /// `text`) for a line that does not fit; its rest is skipped. Not for use with allow_waits().
  Status line(std::span<char> text, std::size_t& size) {
    size = 0;
    std::uint8_t byte = 0;
    Status status = next(byte);
    ILP_TRY(status);
    bool fits = true;
    // Bounded by the file: every turn consumes a byte of it.
    for (; status.ok() && byte != '\n'; status = next(byte)) {
      fits = size + 1 < text.size();
      if (fits) text[size++] = static_cast<char>(byte);
    }
    if (!status.ok() && !status.is(StatusCode::end_of_stream)) return status;
    text[size] = 0;
    return fits ? Status{} : Status{StatusCode::parse_error, static_cast<std::int64_t>(text.size())};
  }

 private:
  /// Waits for bytes within the limit of allow_waits(); returns `not_ready` beyond it.
  Status await() {
    if (!live_ || wait_readable(file_, 0)) return {};
    for (; waits_ > 0; --waits_) {
      if (wait_readable(file_, wait_ms_)) return {};
    }
    return StatusCode::not_ready;
  }

  int file_ = -1;
  std::array<std::uint8_t, 4096> buffer_{};
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::int64_t total_ = 0;  ///< bytes read since attach()
  bool live_ = false;       ///< allow_waits() was called
  int waits_ = 0;
  int wait_ms_ = 0;
};

}  // namespace ilp
