#include "fsw/shared/find.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "hal/store/ram/ram_store.hpp"
#include "tests/support/failing_store.hpp"

namespace ilp {
namespace {

constexpr StatusCode codes[] = {
#define ILP_STATUS(number, name, ...) StatusCode::name,
#include "fsw/base/status_list.inc"
#undef ILP_STATUS
};

// A record that is skipped although it is there, and could be read later, is lost.
TEST(FindTest, OnlyAGoneOrDamagedRecordIsNoneAndEveryOtherFaultIsReturned) {
  std::vector<std::byte> region(std::size_t{1} << 20U);
  const auto ram = std::make_unique<RamStore>(region);
  test::FailingStore store(*ram);
  for (const StatusCode code : codes) {
    if (code == StatusCode::ok) continue;
    store.judge_by([code](const test::FailingStore::Call&) { return Status{code, 7}; });
    CaptureRecord capture;
    const Result<bool> found = find(Reader<CaptureRecord>(store), 1, capture);
    const bool gone = code == StatusCode::not_found || code == StatusCode::record_damaged;
    EXPECT_EQ(found.ok(), gone) << status_name(code);
    if (found.ok())
      EXPECT_FALSE(found.value());
    else
      EXPECT_TRUE(found.status().is(code)) << status_name(code);
  }
}

}  // namespace
}  // namespace ilp
