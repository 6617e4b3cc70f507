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
  /// Takes a descriptor, which stays the caller's.
  void attach(int file) {
    file_ = file;
    begin_ = 0;
    end_ = 0;
    total_ = 0;
    live_ = false;
  }
  /// Until the next call, reads of bytes that have not arrived wait `waits` times at most, `wait_ms` each. Then they
  /// return `not_ready`. Without a call, reads wait for ever.
  void allow_waits(int waits, int wait_ms) {
    live_ = true;
    waits_ = waits;
    wait_ms_ = wait_ms;
  }
  /// `end_of_stream` (a = bytes read so far) after the last byte.
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
  /// Reads until `bytes` is full, from its byte `got` on, or returns `truncated` (a = bytes read, b = bytes wanted).
  /// After `not_ready`, `got` says how many bytes have arrived.
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
  Status fill(std::span<std::uint8_t> bytes) {
    std::size_t got = 0;
    return fill(bytes, got);
  }
  /// Reads the next line of a text, `size` octets, into `text`, with a terminator instead of the line's end. The last
  /// line may lack its end. `end_of_stream` when no byte is left; `parse_error` (a = capacity) for a line that does not
  /// fit, which is read to its end. Not for live descriptors.
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
  std::int64_t total_ = 0;
  bool live_ = false;
  int waits_ = 0;
  int wait_ms_ = 0;
};

}  // namespace ilp
