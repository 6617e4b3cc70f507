#include "bsp/linux/status_line.hpp"

#include <cstdio>

namespace ilp {

void print_status(const char* what, const Status& status, const char* why) {
  std::fprintf(stderr, "ilp-onboard: %s: %s%s%s: %s\n", what, status_words(status).c_str(), *why == 0 ? "" : ": ", why,
               status_advice(status.code));
}

}  // namespace ilp
