#include "bsp/flight/mission_file.hpp"

#include <ini.h>

#include <cstdio>
#include <cstdlib>

#include "fsw/base/text.hpp"

namespace ilp {
namespace {

struct Reading {
  MissionParameters mission;
  MissionFileError error;
  Status status;
};

int take_entry(void* user, const char* section, const char* key, const char* value) {
  auto& reading = *static_cast<Reading*>(user);
  if (!reading.status.ok()) return 1;
  char* end = nullptr;
  const double number = std::strtod(value, &end);
  const bool is_number = end != value && *end == 0;
  reading.status = is_number ? set_parameter(reading.mission, section, key, number) : StatusCode::invalid_argument;
  if (!reading.status.ok()) {
    copy_text(reading.error.section, section);
    copy_text(reading.error.key, key);
    copy_text(reading.error.value, value);
  }
  return 1;
}

/// Longer lines are cut by the reader, and what is behind the cut would be read as a line of its own.
constexpr int longest_line = 198;

/// What the reader would pass over in silence: octets that are no text, lines that are too long, a file that cannot be
/// read to its end. `parse_error` (a = line), `io_error`.
Status check_text(std::FILE* file) {
  std::int64_t line = 1;
  int length = 0;
  // Bounded by the file.
  for (int octet = std::fgetc(file); octet != EOF; octet = std::fgetc(file)) {
    if (octet == 0 || ++length > longest_line) return {StatusCode::parse_error, line};
    if (octet != '\n') continue;
    ++line;
    length = 0;
  }
  if (std::ferror(file) != 0) return {StatusCode::io_error, line};
  std::rewind(file);
  return {};
}

}  // namespace

Status read_mission_file(const char* path, MissionParameters& mission, MissionFileError& error) {
  Reading reading;
  reading.mission = mission;
  error = {};
  std::FILE* const file = std::fopen(path, "r");
  if (file == nullptr) return StatusCode::not_found;
  const Status text = check_text(file);
  const int result = text.ok() ? ini_parse_file(file, take_entry, &reading) : 0;
  static_cast<void>(std::fclose(file));
  ILP_TRY(text);
  error = reading.error;
  // A malformed section line makes strangers of the entries below it: it is the fault to name.
  const bool section_missing = reading.error.key[0] != 0 && reading.error.section[0] == 0;
  if (result > 0 && (reading.status.ok() || section_missing)) {
    error = {};
    return {StatusCode::parse_error, result};
  }
  if (!reading.status.ok()) return reading.status;
  const Status valid = validate(reading.mission);
  if (!valid.ok()) return {StatusCode::parameters_contradict, valid.a};
  mission = reading.mission;
  return {};
}

}  // namespace ilp
