#include "bsp/linux/status_line.hpp"

#include <cstdio>
#include <cstring>

namespace ilp {

FixedText<512> status_sentence(const Status& status) {
  FixedText<512> text;
  for (const char* c = status_text(status.code); *c != 0; ++c) {
    const bool value = *c == '%' && (c[1] == 'a' || c[1] == 'b');
    if (value) {
      text.add(*++c == 'a' ? status.a : status.b);
    } else {
      text.add(*c);
    }
  }
  if (status.is(StatusCode::io_error) && status.a > 0) text.add(", ").add(std::strerror(static_cast<int>(status.a)));
  return text;
}

void print_status(const char* what, const Status& status, const char* why) {
  std::fprintf(stderr, "ilp-onboard: %s: %s%s%s: %s\n", what, status_sentence(status).c_str(), *why == 0 ? "" : ": ",
               why, status_advice(status.code));
}

}  // namespace ilp
