// The software's tests of its board before the flight.
#pragma once

#include <array>
#include <cstdint>

#include "fsw/base/enumeration.hpp"
#include "hal/clock/clock.hpp"
#include "hal/store/store.hpp"

namespace ilp {

ILP_ENUMERATION(SelfTest, (0, arithmetic, "elementary functions give the same bits as everywhere"),
                (1, checksums, "the check values of CRC-16 and CRC-32"), (2, clock, "it advances, and never goes back"),
                (3, store, "a record is written and read back, and a transaction rolled back"),
                (4, codec, "a picture with a region is coded with the same octets as everywhere"),
                (5, disk, "noted by a flight that has its store in memory because its disk failed"))

struct SelfTestResults {
  std::uint32_t tested = 0;  ///< bit k: test k was run
  std::uint32_t failed = 0;
  std::array<std::int64_t, static_cast<std::size_t>(SelfTest::count)> values{};  ///< results of the failed tests

  void note(SelfTest test, bool passed, std::int64_t value);
};

/// Runs all tests. The store is unchanged afterwards. The camera grades itself when its frames arrive.
[[nodiscard]] SelfTestResults run_self_tests(Store& store, Clock& clock);

/// Digest of the arithmetic test's results: the same on every machine.
[[nodiscard]] std::uint32_t arithmetic_digest();

}  // namespace ilp
