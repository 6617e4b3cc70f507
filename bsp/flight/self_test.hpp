// Tests of the board that the software runs before the flight.
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
  std::uint32_t tested = 0;                                                      ///< bit k: test k was run
  std::uint32_t failed = 0;                                                      ///< bit k: test k has failed
  std::array<std::int64_t, static_cast<std::size_t>(SelfTest::count)> values{};  ///< results of the failed tests

  /// Enters the result of a test.
  void note(SelfTest test, bool passed, std::int64_t value);
};

/// Runs all tests; the store is unchanged afterwards. The camera is tested later by its first frames (DriverGrade).
[[nodiscard]] SelfTestResults run_self_tests(Store& store, Clock& clock);

/// Digest of the arithmetic test's results, which must be the same on every machine.
[[nodiscard]] std::uint32_t arithmetic_digest();

}  // namespace ilp
