#include <gtest/gtest.h>

#include <sstream>

#include "sim/io/colmap_camera.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {
namespace fs = std::filesystem;

const fs::path plain = test::prepared_flights() / "plain";

std::string camera_numbers() {
  const CameraModel c = sim::read_colmap_camera(plain / "cameras.txt");
  std::ostringstream text;
  text.precision(17);
  text << c.width << " " << c.height << " " << c.fx << " " << c.fy << " " << c.cx << " " << c.cy;
  return text.str();
}

TEST(OnboardTest, TheFlightBinaryAllocatesNothingInFlightAndMakesTheSameProducts) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "outbox");
  fs::create_directories(folder / "acknowledged");
  const test::ProgramResult result =
      test::run_program({ILP_ONBOARD, "--virtual-time", "--trap-heap", "--index", (plain / "index.txt").string(),
                         "--camera", camera_numbers(), "--database", folder / "flight.db", "--outbox",
                         folder / "outbox", "--acknowledgements", folder / "acknowledged"});
  ASSERT_EQ(result.exit_status, 0) << result.output;
  EXPECT_NE(result.output.find("heap requests after sealing: 0\n"), std::string::npos) << result.output;
  test::expect_same_files(test::files_of(test::prepared_flights() / "uninterrupted" / "outbox", {"product-"}),
                          test::files_of(folder / "outbox", {"product-"}));
}

TEST(OnboardTest, MissingFilesAndFoldersAreNamed) {
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "outbox");
  fs::create_directories(folder / "acknowledged");
  const auto fly = [&](const std::string& index, const std::string& database, const std::string& outbox) {
    return test::run_program({ILP_ONBOARD, "--virtual-time", "--index", index, "--camera", camera_numbers(),
                              "--database", database, "--outbox", outbox, "--acknowledgements",
                              folder / "acknowledged"});
  };
  const std::string index = (plain / "index.txt").string();
  const test::ProgramResult no_index = fly(folder / "none.txt", folder / "a.db", folder / "outbox");
  EXPECT_EQ(no_index.exit_status, 1);
  EXPECT_NE(no_index.output.find("none.txt"), std::string::npos) << no_index.output;
  const test::ProgramResult no_database = fly(index, folder / "none/a.db", folder / "outbox");
  EXPECT_EQ(no_database.exit_status, 1);
  EXPECT_NE(no_database.output.find("none/a.db"), std::string::npos) << no_database.output;
  const test::ProgramResult no_outbox = fly(index, folder / "b.db", folder / "none");
  EXPECT_EQ(no_outbox.exit_status, 1);
  EXPECT_NE(no_outbox.output.find("outbox"), std::string::npos) << no_outbox.output;
}

}  // namespace
}  // namespace ilp
