// What a flight leaves on disk by default: at most 60 MB for 1 MB of downlink, beside what only the simulator has.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

std::uintmax_t bytes_in(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return bytes;
}

TEST(DiskUse, IsAtMostSixtyTimesTheDownlink) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  const test::ToolResult run =
      test::run_tool(ILP_SOURCE "/sim/fly --programs " ILP_PROGRAMS
                                " --frames 30 --seed 11 --set navigation.altimeter=true "
                                "--set navigation.attitude=true --set navigation.position=true --out " +
                     test::quoted(out) + " 2>&1");
  ASSERT_EQ(run.status, 0) << run.output;
  // Images and truth of the simulator.
  const std::uintmax_t left = bytes_in(out) - bytes_in(out / "flight"), downlink = bytes_in(out / "outbox");
  EXPECT_GT(downlink, 300'000U);
  EXPECT_LE(left, 60 * downlink);
}

}  // namespace
}  // namespace ilp
