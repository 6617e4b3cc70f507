#include "sim/io/status_error.hpp"

#include <stdexcept>

namespace ilp::sim {
namespace {

void replace(std::string& text, const std::string& place, const std::string& value) {
  const std::size_t at = text.find(place);
  if (at != std::string::npos) text.replace(at, place.size(), value);
}

}  // namespace

std::string describe(const Status& status) {
  std::string text = status_text(status.code);
  replace(text, "%a", std::to_string(status.a));
  replace(text, "%b", std::to_string(status.b));
  return text + " (" + status_advice(status.code) + ")";
}

void require(const Status& status, const std::string& what) {
  if (!status.ok()) throw std::runtime_error(what + ": " + describe(status));
}

}  // namespace ilp::sim
