#include "bsp/linux/status_line.hpp"

#include <cstdio>

#include "fsw/base/text.hpp"

namespace ilp {

void print_status(const char* what, const Status& status, const char* why) {
  FixedText<512> text;
  for (const char* c = status_text(status.code); *c != 0; ++c) {
    const bool value = *c == '%' && (c[1] == 'a' || c[1] == 'b');
    if (value) {
      text.add(*++c == 'a' ? status.a : status.b);
    } else {
      text.add(*c);
    }
  }
  std::fprintf(stderr, "ilp-onboard: %s: %s%s%s: %s\n", what, text.c_str(), *why == 0 ? "" : ": ", why,
               status_advice(status.code));
}

}  // namespace ilp
