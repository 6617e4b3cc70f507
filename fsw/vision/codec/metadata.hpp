// Metadata of a product: lines of text `key=value` that can be read without this software.
//
//   keyframe=17
//   camera_fx=1182.25
//   sigma=0x1.3p-7
//
// Keys consist of letters, digits, `_`, `.` and `-`; values of printable bytes up to the end of the line. A double is
// written as a decimal number if at most 15 digits give back exactly the same value, otherwise in C99's hexadecimal
// form. Both forms are exact and depend on neither locale nor machine. The numbers of a list are separated by single
// blanks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "fsw/base/status.hpp"

namespace ilp {

/// Appends lines to a fixed buffer. After the first error later calls do nothing; status() returns that error.
class MetadataWriter {
 public:
  explicit MetadataWriter(std::span<std::uint8_t> buffer) : buffer_(buffer) {}

  void text(std::string_view key, std::string_view value);
  void integer(std::string_view key, std::int64_t value);
  void real(std::string_view key, double value);
  void reals(std::string_view key, std::span<const double> values);

  /// Returns the first error: `capacity_exceeded` if a line did not fit (the line is left out), `invalid_argument` if a
  /// key or value has bytes that are not allowed.
  Status status() const { return status_; }
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return buffer_.first(size_); }

 private:
  void put(char c);
  void put(std::string_view text);
  void put_real(double value);
  bool begin(std::string_view key);
  void end(std::size_t start);

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
  bool overflow_ = false;
  Status status_;
};

/// Looks up values in text of a MetadataWriter or of any other source. Lines that are not `key=value` are skipped; if a
/// key occurs several times, its first line counts. Each lookup reads the text from its start.
class MetadataReader {
 public:
  explicit MetadataReader(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// Return the value of a key: `not_found` if the key is missing, `parse_error` (a: offset of the value) if the value
  /// has another type.
  Status text(std::string_view key, std::string_view& value) const;
  Status integer(std::string_view key, std::int64_t& value) const;
  Status real(std::string_view key, double& value) const;
  /// Reads exactly values.size() numbers.
  Status reals(std::string_view key, std::span<double> values) const;

  /// Iterates over all lines. Set `position` to 0 before the first call. Returns `end_of_stream` after the last line.
  Status next(std::size_t& position, std::string_view& key, std::string_view& value) const;

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace ilp
