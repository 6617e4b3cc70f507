#include "sim/host/status_error.hpp"

#include <stdexcept>

#include "bsp/flight/status_text.hpp"
#include "fsw/base/status.hpp"

namespace ilp::host {
namespace {

bool known(std::uint16_t code) {
  return is_status_code(code);
}

}  // namespace

std::string status_sentence(const Status& status) {
  return status_words(status).c_str();
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

std::string component_name(std::uint64_t number) {
  return value_text(ValueType::component, static_cast<std::int64_t>(number)).c_str();
}

const char* severity_name(std::uint8_t severity) {
  return words_of(static_cast<Severity>(severity));
}

}  // namespace ilp::host
