#include "sim/host/status_error.hpp"

#include <stdexcept>

namespace ilp::host {
std::string status_sentence(const Status& status) {
  std::string sentence;
  for (const char* c = status_text(status.code); *c != '\0'; ++c) {
    if (c[0] == '%' && (c[1] == 'a' || c[1] == 'b')) {
      sentence += std::to_string(c[1] == 'a' ? status.a : status.b);
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

}  // namespace ilp::host
