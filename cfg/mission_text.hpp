// Parser of mission files: mission parameters as text, [section] key = value, where ';' and '#' begin comments. Files
// on board, files from the ground and files on a host have the same grammar.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cfg/mission.hpp"
#include "fsw/base/status.hpp"

namespace ilp {

/// The wrong entry of a mission file, for the message to its author; empty if the line is no entry.
struct MissionEntry {
  char section[32] = {};
  char key[48] = {};
  char value[32] = {};
};

/// Takes a text in parts of any size, and sets either all of its parameters or none. Lines have at most 255 octets.
class MissionText {
 public:
  /// Parameters that the text does not name keep the values of `mission`.
  explicit MissionText(const MissionParameters& mission) : mission_(mission) {}

  void add(std::span<const std::uint8_t> text);
  /// Call it after the last part. Returns `parse_error` (first value: line) for a malformed line, `not_found` (first
  /// value: line) for an unknown parameter, `parameter_out_of_range` (second value: line) for a value that the
  /// parameter cannot have, or the fault of validate(). `mission` changes only if there is no fault.
  Status finish(MissionParameters& mission);
  /// The entry of the first fault.
  [[nodiscard]] const MissionEntry& fault() const { return fault_; }

 private:
  void end_line();
  Status take_line();
  Status take_entry(const char* key, const char* text);

  MissionParameters mission_;
  Status status_;
  MissionEntry fault_;
  std::int64_t line_ = 1;
  std::size_t size_ = 0;
  bool too_long_ = false;
  char text_[256] = {};
  char section_[32] = {};
};

/// Reads a decimal number with an optional exponent, as the nearest double. Returns `false` for other text.
[[nodiscard]] bool parse_decimal(const char* text, double& value);

/// Reads the value of a parameter: a decimal number, the name of a choice, or `true` or `false` for a flag. An angle is
/// in radians, or in degrees if `deg` follows the number. Returns `false` for other text. The range is not checked
/// here, but by set_parameter.
[[nodiscard]] bool parse_value(const ParameterInfo& info, const char* text, double& value);

}  // namespace ilp
