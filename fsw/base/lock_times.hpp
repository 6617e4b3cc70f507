// The latest time for which another process kept the lock of the store, as one writer has found it.
#pragma once

#include <cstdint>

#include "fsw/base/time.hpp"

namespace ilp {

struct LockTimes {
  enum class Is : std::uint8_t { never_found, taken, free_again } is = Is::never_found;
  TimeNs begin_ns = 0;
  TimeNs end_ns = 0;  ///< of one that is `free_again`

  [[nodiscard]] bool taken() const { return is == Is::taken; }
  void note(bool found_taken, TimeNs now) {
    if (found_taken && !taken()) begin_ns = now;
    if (!found_taken && taken()) end_ns = now;
    if (found_taken || taken()) is = found_taken ? Is::taken : Is::free_again;
  }
};

}  // namespace ilp
