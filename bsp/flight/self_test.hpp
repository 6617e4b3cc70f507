// What the software asks of its board before it flies.
#pragma once

#include <array>
#include <cstdint>

#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

enum class SelfTest : std::uint8_t {
  arithmetic,  ///< elementary functions give the same bits as everywhere
  checksums,   ///< the check values of CRC-16 and CRC-32
  clock,       ///< it goes on, and never back
  store,       ///< a record is written and read back, and a transaction rolled back
  camera,      ///< the camera keeps what it promises; graded by the camera itself
  count
};
[[nodiscard]] const char* self_test_name(SelfTest test);

struct SelfTestResults {
  std::uint32_t tested = 0;  ///< bit k: test k was run
  std::uint32_t failed = 0;
  std::array<std::int64_t, static_cast<std::size_t>(SelfTest::count)>
      values{};  ///< of those that failed: what was found

  void note(SelfTest test, bool passed, std::int64_t value);
};

/// All of them but the camera's. Nothing is left behind in the store.
[[nodiscard]] SelfTestResults run_self_tests(Store& store, Clock& clock);

/// Digest of what the arithmetic test computes: the same on every machine.
[[nodiscard]] std::uint32_t arithmetic_digest();

}  // namespace ilp
