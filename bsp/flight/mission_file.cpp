#include "bsp/flight/mission_file.hpp"

#include <ini.h>

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

}  // namespace

Status read_mission_file(const char* path, MissionParameters& mission, MissionFileError& error) {
  Reading reading;
  reading.mission = mission;
  const int result = ini_parse(path, take_entry, &reading);
  error = reading.error;
  if (result < 0) return StatusCode::not_found;
  // A malformed section line makes strangers of the entries below it: it is the fault to name.
  const bool section_missing = reading.error.key[0] != 0 && reading.error.section[0] == 0;
  if (result > 0 && (reading.status.ok() || section_missing)) {
    error = {};
    return {StatusCode::parse_error, result};
  }
  if (!reading.status.ok()) return reading.status;
  ILP_TRY(validate(reading.mission));
  mission = reading.mission;
  return {};
}

}  // namespace ilp
