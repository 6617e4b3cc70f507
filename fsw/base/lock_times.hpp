// When another process last held the lock of the store, as one writer has observed it.
#pragma once

#include <cstdint>

#include "fsw/base/time.hpp"

namespace ilp {

/// The latest period in which the lock was found taken.
struct LockTimes {
  enum class Is : std::uint8_t { never_found, taken, free_again } is = Is::never_found;
  TimeNs begin_ns = 0;
  TimeNs end_ns = 0;  ///< valid if `is` is free_again

  [[nodiscard]] bool taken() const { return is == Is::taken; }
  /// Notes an attempt to take the lock: whether another process held it.
  void note(bool found_taken, TimeNs now) {
    if (found_taken && !taken()) begin_ns = now;
    if (!found_taken && taken()) end_ns = now;
    if (found_taken || taken()) is = found_taken ? Is::taken : Is::free_again;
  }
};

}  // namespace ilp
