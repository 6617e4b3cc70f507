#include "sim/host/status_error.hpp"

#include <cstring>
#include <stdexcept>

#include "fsw/base/status.hpp"
#include "fsw/vision/multiview/sequence.hpp"
#include "fsw/vision/overlap/overlap.hpp"

namespace ilp::host {
namespace {

bool known(std::uint16_t code) {
  return is_status_code(code);
}

}  // namespace

namespace {

/// A value that stands for an enumerated one is written in its words.
std::string words_for(const Status& status, char value) {
  const std::int64_t number = value == 'a' ? status.a : status.b;
  if (status.is(StatusCode::io_error) && value == 'a' && number > 0)
    return std::to_string(number) + ", " + std::strerror(static_cast<int>(number));
  if (status.is(StatusCode::strip_broken) && value == 'b') return words_of(static_cast<StripEnd>(number));
  if ((status.is(StatusCode::calibration_waiting) || status.is(StatusCode::camera_nominal)) && value == 'b')
    return std::to_string(number) + ", " + words_of(static_cast<CalibrationVerdict>(number));
  return std::to_string(number);
}

}  // namespace

std::string status_sentence(const Status& status) {
  std::string sentence;
  for (const char* c = status_text(status.code); *c != '\0'; ++c) {
    if (c[0] == '%' && (c[1] == 'a' || c[1] == 'b')) {
      sentence += words_for(status, c[1]);
      ++c;
    } else {
      sentence += *c;
    }
  }
  return sentence;
}

std::string describe(const Status& status) {
  return status_sentence(status) + " (" + status_advice(status.code) + ")";
}

void require(const Status& status, const std::string& what) {
  if (!status.ok()) throw std::runtime_error(what + ": " + describe(status));
}

std::string event_name(std::uint16_t code) {
  return known(code) ? status_name(static_cast<StatusCode>(code)) : "code " + std::to_string(code);
}

std::string event_sentence(const EventRecord& event) {
  if (!known(event.code)) {
    return "unknown to this program, values " + std::to_string(event.a) + " and " + std::to_string(event.b);
  }
  return status_sentence({static_cast<StatusCode>(event.code), event.a, event.b});
}

std::string event_advice(std::uint16_t code) {
  return known(code) ? status_advice(static_cast<StatusCode>(code)) : "use the ground software of the flight's version";
}

const char* severity_name(std::uint8_t severity) {
  return words_of(static_cast<Severity>(severity));
}

}  // namespace ilp::host
