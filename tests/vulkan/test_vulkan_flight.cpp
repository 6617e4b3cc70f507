// A flight whose wide searches a Vulkan device does, all of them or until it is killed: the store has
// the same records as with the processor alone.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/flight_files.hpp"
#include "tests/support/strip.hpp"
#include "tests/unit/hal/temporary_folder.hpp"
#include "tests/unit/vision/overlap/ground_texture.hpp"
#include "tests/vulkan/vulkan_program.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;

constexpr std::int32_t width = 128, height = 96;
constexpr int frames = 7;
// Between these two frames the camera turns by more than the coarse search covers.
constexpr int turned_from = 4;

/// A strip over one ground; from frame `turned` on the camera has turned.
void write_strip(const fs::path& folder, int turned) {
  const test::GroundTexture ground(test::Ground::craters, 82001);
  std::ofstream index(folder / "index.txt");
  for (int i = 0; i < frames; ++i) {
    Rng rng(static_cast<std::uint64_t>(i), 93);
    test::Exposure exposure;
    exposure.noise = 1;
    const double turn = i >= turned ? 2.2 : 0;
    const Similarity2 centred = test::about_centre(1.5, turn, 0, 0, width, height);
    const Similarity2 from{1.5, turn, 300 + centred.shift_x_px + 36 * i, 300 + centred.shift_y_px};
    const test::Image image = test::look_at(ground, {}, from, width, height, exposure, rng);
    const std::string name = std::to_string(i) + ".pgm";
    std::ofstream pgm(folder / name, std::ios::binary);
    pgm << "P5\n" << width << " " << height << "\n255\n";
    pgm.write(reinterpret_cast<const char*>(image.pixels.data()), static_cast<std::streamsize>(image.pixels.size()));
    index << i * 4'000'000'000LL << " " << name << "\n";
  }
}

class VulkanFlight : public testing::Test {
 protected:
  /// Flies the strip; `digest` gets a checksum of each table of its results.
  std::vector<OverlapRecord> fly(const std::string& name, bool searches, const char* socket, std::string& digest) {
    const fs::path out = fs::path(std::string(folder_ / name));
    fs::create_directories(out / "outbox");
    fs::create_directories(out / "acknowledged");
    const std::string mission = (out / "mission.ini").string();
    test::write_file(mission, std::string("[overlap]\nwide_search = ") + (searches ? "true\n" : "false\n"));
    std::vector<std::string> command = {
        ILP_ONBOARD,    "--virtual-time",           "--trap-heap",        "--index",         folder_ / "index.txt",
        "--camera",     "128 96 110 110 63.5 47.5", "--database",         out / "flight.db", "--outbox",
        out / "outbox", "--acknowledgements",       out / "acknowledged", "--mission",       mission};
    if (socket != nullptr) command.insert(command.end(), {"--compute", socket});
    const test::ProgramResult result = test::run_program(command);
    EXPECT_EQ(result.exit_status, 0) << result.output;
    EXPECT_NE(result.output.find("heap requests after sealing: 0\n"), std::string::npos) << result.output;
    digest = test::run_program({ILP_STORE, "digest", out / "flight.db"}).output;
    EXPECT_NE(digest.find("overlap"), std::string::npos) << digest;
    return test::records_of<OverlapRecord>(out);
  }

  test::TemporaryFolder folder_;
};

TEST_F(VulkanFlight, ADeviceOrOneThatIsKilledLeavesTheSameRecords) {
  write_strip(folder_ / ".", turned_from);
  std::string without, cpu, device, killed;
  static_cast<void>(fly("without", false, nullptr, without));
  const std::vector<OverlapRecord> records = fly("cpu", true, nullptr, cpu);
  ASSERT_EQ(records.size(), static_cast<std::size_t>(frames));
  // The search has related the turned frame, which changes the flight.
  EXPECT_EQ(records[turned_from].verdict, OverlapVerdict::ok);
  EXPECT_NEAR(std::fabs(records[turned_from].rotation_rad), 2.2, 0.01);
  EXPECT_NE(without, cpu);
  const fs::path out = fs::path(std::string(folder_ / "."));
  {
    const test::VulkanProgram program;
    static_cast<void>(fly("device", true, program.socket(), device));
    EXPECT_EQ(test::events_of(out / "device", StatusCode::compute_ready), 1U);
    EXPECT_EQ(test::events_of(out / "device", StatusCode::compute_lost), 0U);
  }
  {
    const test::VulkanProgram program;
    std::thread killer([&] {
      // In the search of the turned frame, which takes many seconds.
      for (int i = 0; i < 1200 && test::records_of<OverlapRecord>(out / "killed").size() < turned_from; ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(500));
      program.send(SIGKILL);
    });
    static_cast<void>(fly("killed", true, program.socket(), killed));
    killer.join();
    EXPECT_EQ(test::events_of(out / "killed", StatusCode::compute_lost), 1U);
  }
  EXPECT_EQ(device, cpu);
  EXPECT_EQ(killed, cpu);
}

}  // namespace
}  // namespace ilp
