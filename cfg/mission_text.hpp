// Mission parameters as text: [section] key = value, where ';' and '#' begin comments. Files on board, files from the
// ground and files on a host are parsed piece by piece with this grammar.
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

/// Takes a text in pieces of any size and sets all of its parameters or none. Lines have at most 255 octets.
class MissionText {
 public:
  /// Values that the text does not name stay as they are in `mission`.
  explicit MissionText(const MissionParameters& mission) : mission_(mission) {}

  void add(std::span<const std::uint8_t> text);
  /// Call it after the last piece. `parse_error` (a = line) for a malformed line, `not_found` (a = line) for an unknown
  /// parameter, `parameter_out_of_range` (b = line) for a value that the parameter cannot have, or the Status of
  /// validate(). `mission` changes only if the whole text is right.
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

/// A decimal number with an optional exponent, as the nearest double; `false` for anything else.
[[nodiscard]] bool parse_decimal(const char* text, double& value);

/// Reads the value of a parameter from a decimal number, the name of a choice, or `true` or `false` of a flag. An angle
/// is in radians, or in degrees if `deg` follows the number. Returns `false` for other text; set_parameter checks the
/// range.
[[nodiscard]] bool parse_value(const ParameterInfo& info, const char* text, double& value);

}  // namespace ilp
