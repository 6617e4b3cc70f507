#include "bsp/flight/self_test.hpp"

#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "fsw/base/crc.hpp"
#include "fsw/base/math.hpp"
#include "fsw/packets/crc16.hpp"
#include "fsw/vision/codec/openjpeg_codec.hpp"

namespace ilp {
namespace {

constexpr std::uint32_t expected_arithmetic = 0x6EB83255;

void add(std::uint32_t& digest, double value) {
  std::uint8_t bytes[sizeof(value)];
  std::memcpy(bytes, &value, sizeof(value));
  digest = crc32(bytes, digest);
}

void test_arithmetic(SelfTestResults& results) {
  const std::uint32_t digest = arithmetic_digest();
  results.note(SelfTest::arithmetic, digest == expected_arithmetic, digest);
}

void test_checksums(SelfTestResults& results) {
  // The published check values of the polynomials.
  constexpr std::uint8_t digits[] = {'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  const std::uint32_t long_sum = crc32(digits);
  const std::uint16_t short_sum = crc16(digits);
  const bool passed = long_sum == 0xCBF43926U && short_sum == 0x29B1U;
  results.note(SelfTest::checksums, passed, (static_cast<std::int64_t>(long_sum) << 16U) + short_sum);
}

void test_clock(Clock& clock, SelfTestResults& results) {
  constexpr int reads = 1000;
  const TimeNs begin = clock.now();
  TimeNs before = begin;
  TimeNs worst = 0;
  for (int i = 0; i < reads; ++i) {
    const TimeNs now = clock.now();
    if (now - before < worst) worst = now - before;
    before = now;
  }
  clock.sleep_until(begin + ns_per_ms);
  const TimeNs slept = clock.now() - begin;
  results.note(SelfTest::clock, worst == 0 && slept >= ns_per_ms && slept < 10 * ns_per_s, worst != 0 ? worst : slept);
}

Status try_store(Store& store) {
  // Beyond every number of a flight.
  constexpr std::int64_t id = std::numeric_limits<std::int64_t>::max();
  StartRecord written;
  written.id = id;
  written.time_ns = 0x0123456789ABCDEF;
  written.stack_bytes = 0x89ABCDEF;
  StartRecord read;
  {
    Transaction transaction(store);
    ILP_TRY(transaction.begin());
    ILP_TRY(put(store, written));
    ILP_TRY(get(store, id, read));
  }
  const bool same = read.time_ns == written.time_ns && read.stack_bytes == written.stack_bytes;
  if (!same) return {StatusCode::store_error, 0, read.time_ns};
  const Status after = get(store, id, read);
  if (after.is(StatusCode::not_found)) return {};
  return after.ok() ? Status{StatusCode::store_error, 0, read.id} : after;
}

void test_store(Store& store, SelfTestResults& results) {
  const Status status = try_store(store);
  results.note(SelfTest::store, status.ok(), static_cast<std::int64_t>(status.code));
}

void test_codec(SelfTestResults& results) {
  const std::uint32_t digest = openjpeg_digest();
  results.note(SelfTest::codec, digest == tested_openjpeg_digest, digest);
}

}  // namespace

void SelfTestResults::note(SelfTest test, bool passed, std::int64_t value) {
  const auto index = static_cast<std::size_t>(test);
  tested |= std::uint32_t{1} << index;
  if (passed) return;
  failed |= std::uint32_t{1} << index;
  values[index] = value;
}

std::uint32_t arithmetic_digest() {
  std::uint32_t digest = 0;
  double sum = 0;
  for (int i = 1; i <= 64; ++i) {
    const double x = 0.37 * i;
    const double values[] = {det_sin(x), det_cos(x),      det_atan2(x - 9, 5 - x), det_asin(x / 32), det_exp(x / 4),
                             det_log(x), det_pow(x, 1.7), det_cbrt(x - 12),        std::sqrt(x + 1), std::floor(-x)};
    for (const double value : values) {
      // A fused multiply-add would round once where this rounds twice.
      sum = sum * 0.999 + value * x;
      add(digest, value);
    }
    add(digest, sum);
  }
  return digest;
}

SelfTestResults run_self_tests(Store& store, Clock& clock) {
  SelfTestResults results;
  test_arithmetic(results);
  test_checksums(results);
  test_clock(clock, results);
  test_store(store, results);
  test_codec(results);
  return results;
}

}  // namespace ilp
