// Mission parameters as text, piece by piece: [section] key = value, ';' and '#' begin comments. What a mission's .ini
// file holds, for those who get it by radio.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/mission.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// All or nothing. Lines have at most 255 octets, numbers at most 15 digits.
class MissionText {
 public:
  /// Values that the text does not name stay as they are in `mission`.
  explicit MissionText(const MissionParameters& mission) : mission_(mission) {}

  void add(std::span<const std::uint8_t> text);
  /// Behind the last piece. `parse_error` (a = line) for a malformed line, `not_found` (a = line) for an unknown
  /// parameter, `invalid_argument` for a value out of range (a = line) or for parameters that contradict each other
  /// (a = 0, b = which, see validate). `mission` is changed only when all is right.
  Status finish(MissionParameters& mission);

 private:
  void end_line();
  Status take_line();

  MissionParameters mission_;
  Status status_;
  std::int64_t line_ = 1;
  std::size_t size_ = 0;
  bool too_long_ = false;
  char text_[256] = {};
  char section_[32] = {};
};

/// A decimal number with an optional exponent, exactly rounded; `false` for anything else.
[[nodiscard]] bool parse_decimal(const char* text, double& value);

}  // namespace ilp
