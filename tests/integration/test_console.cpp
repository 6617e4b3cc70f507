// The operator's console, as a script uses it, against a flight in real time.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/integration/running_program.hpp"
#include "tests/support/said.hpp"
#include "tests/unit/ground/export/tool.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;
using test::quoted;
using test::RunningProgram;
using test::ToolResult;

class ConsoleTest : public testing::Test {
 protected:
  [[nodiscard]] fs::path path(const char* name) const { return fs::path(folder_ / name); }

  void write(const char* name, const std::string& text) const { std::ofstream(path(name)) << text; }
  void write_keys(const std::string& text) const {
    write("keys", text);
    fs::permissions(path("keys"), fs::perms::owner_read | fs::perms::owner_write);
  }

  [[nodiscard]] std::vector<std::string> flight(std::vector<std::string> more) const {
    write("mission.ini", mission_);
    std::vector<std::string> command = {ILP_SIL, "--real-time",          "--mission", path("mission.ini").string(),
                                        "--out", path("flight").string()};
    for (const char* setting : {"camera.width=192", "camera.height=144", "camera.fx=165", "camera.fy=165",
                                "camera.cx=-1", "camera.cy=-1", "flight.drift_m_s=12"}) {
      command.insert(command.end(), {"--set", setting});
    }
    command.insert(command.end(), more.begin(), more.end());
    return command;
  }

  /// What the console says to the lines of a script.
  [[nodiscard]] ToolResult operate(const RunningProgram& program, const std::string& transport,
                                   const std::string& script, const std::string& options = "") const {
    const SocketAddress address = program.address("packets over " + transport);
    EXPECT_NE(address.port, 0) << program.output();
    write("script", script);
    return test::run_tool(std::string(ILP_GROUND) + " console 127.0.0.1:" + std::to_string(address.port) +
                          (transport == "TCP" ? " --tcp " : " ") + options + " --status 0 <" + quoted(path("script")) +
                          " 2>&1");
  }

  const test::TemporaryFolder folder_;
  std::string mission_ = "[acquisition]\ncapture_mode = 2\n";
};

bool says(const ToolResult& result, const std::string& text) {
  return result.output.find(text) != std::string::npos;
}

std::vector<fs::path> files_in(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  return files;
}

TEST_F(ConsoleTest, AScriptCommandsTheFlightAndItsFilesComeDown) {
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0"}), path("log"));
  const ToolResult result = operate(program, "UDP",
                                    "ping\nset overlap.target_overlap 0.9\nwait 1\nget overlap.target_overlap\n"
                                    "capture\nwait 2\ncapture +1\nwait 3\nstrip end\nwait 8\npasses\n",
                                    "--out " + quoted(path("down")));
  EXPECT_EQ(result.status, 0) << result.output;
  for (const char* text : {"the flight is alive", "accepted: ping", "started: ping", "done: ping",
                           "done: set overlap.target_overlap 0.9", "  overlap.target_overlap = 0.9", "done: capture\n",
                           "done: capture +1", "done: strip end", "always in contact"}) {
    EXPECT_TRUE(says(result, text)) << text << "\n" << result.output;
  }
  EXPECT_EQ(program.stop(), 0) << program.output();
  const std::string written = test::text_of(path("flight") / "flight-info.json");
  EXPECT_NE(written.find("\"target_overlap\": 0.9,"), std::string::npos) << "what was set counts: " << written;
  std::size_t images = 0;
  for (const fs::path& file : files_in(path("down"))) {
    const std::string content = test::text_of(file);
    EXPECT_TRUE(says(result, "file: " + file.filename().string() + ", " + std::to_string(content.size()) + " bytes"));
    if (file.extension() != ".jp2") continue;
    ++images;
    EXPECT_EQ(content.substr(4, 4), "jP  ") << file;
  }
  EXPECT_GE(images, 2U) << result.output;
}

TEST_F(ConsoleTest, WhoEndsContactIsToldHowLongTheFlightIsSilent) {
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0"}), path("log"));
  const ToolResult result = operate(program, "UDP", "wait 1\npasses\ndownlink end\nwait 1\npasses\nping\nquit\n");
  for (const char* text :
       {"always in contact", "the flight neither sends nor listens until mission time 02:00, for 01:",
        "because a telecommand ended it", "the flight does not listen now: no contact for 01:"}) {
    EXPECT_TRUE(says(result, text)) << text << "\n" << result.output;
  }
  EXPECT_EQ(result.status, 1) << "the ping has no answer";
}

TEST_F(ConsoleTest, WhatFailsIsSaidWithItsReasonAndTheExitStatusTellsIt) {
  RunningProgram program(flight({"--link-tcp", "127.0.0.1:0"}), path("log"));
  const ToolResult result = operate(program, "TCP", "refine 99\nlaunch\nping\n");
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_TRUE(says(result, "failed: refine 99: no such product of keyframe 99 is on board. To do: ")) << result.output;
  EXPECT_TRUE(says(result, "not sent: launch: there is no command launch")) << result.output;
  EXPECT_TRUE(says(result, "done: ping")) << result.output;
}

TEST_F(ConsoleTest, AStationWithoutAFolderTakesNoFileAndNothingIsDeletedOnBoard) {
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0"}), path("log"));
  const ToolResult result =
      operate(program, "UDP", "capture\nwait 2\nstrip end\nwait 6\nshow link\nshow storage\n", "--every 0.5");
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_TRUE(says(result, "files_delivered 0")) << result.output;
  EXPECT_FALSE(says(result, "products_held 0\n")) << result.output;
}

TEST_F(ConsoleTest, AuthenticatedTelecommandsAreCarriedOut) {
  std::string key;
  for (int i = 0; i < 32; ++i) key += "5a";
  write_keys("# the station's\n7 " + key + "\n");
  mission_ += "[link]\nauthentication = 1\n";
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0", "--key", path("keys").string()}), path("log"));
  const ToolResult result = operate(program, "UDP", "ping\n", "--key " + quoted(path("keys")));
  EXPECT_EQ(result.status, 0) << result.output;
  EXPECT_TRUE(says(result, "done: ping")) << result.output;
}

TEST_F(ConsoleTest, WithAuthenticatedFileTransfersFilesComeDownAndGoUpOverARestartOfTheConsole) {
  std::string key;
  for (int i = 0; i < 32; ++i) key += "5a";
  write_keys("7 " + key + "\n");
  write("wide.ini", "[overlap]\ntarget_overlap = 0.85\n");
  mission_ += "[link]\nauthentication = 2\n";
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0", "--key", path("keys").string()}), path("log"));
  const std::string options = "--key " + quoted(path("keys")) + " --out " + quoted(path("down"));
  const ToolResult first = operate(
      program, "UDP", "capture\nwait 2\nuplink " + path("wide.ini").string() + "\nstrip end\nwait 8\n", options);
  EXPECT_EQ(first.status, 0) << first.output;
  EXPECT_TRUE(says(first, ": the flight holds it")) << first.output;
  EXPECT_TRUE(says(first, "uplink_received")) << first.output;
  EXPECT_TRUE(says(first, "file: product-")) << first.output;
  // At once: within the second in which the first console used its last numbers.
  const ToolResult second = operate(program, "UDP",
                                    "uplink " + path("wide.ini").string() +
                                        "\nping\nshow link\nwait 3\nactivate 2\nwait 1\nget overlap.target_overlap\n",
                                    options + " --every 0.5");
  EXPECT_EQ(second.status, 0) << second.output;
  EXPECT_TRUE(says(second, "done: ping")) << second.output;
  EXPECT_TRUE(says(second, ": the flight holds it")) << second.output;
  EXPECT_TRUE(says(second, "done: activate 2")) << second.output;
  EXPECT_TRUE(says(second, "overlap.target_overlap = 0.85")) << second.output;
  EXPECT_FALSE(says(second, "files_delivered 0\n")) << second.output;
}

TEST_F(ConsoleTest, AMapGoesUpAndLiesOnBoardAsItWasMade) {
  const fs::path map = path("map"), on_board = path("on-board");
  const ToolResult made = test::run_tool(
      std::string(ILP_LAB) + " world-map mars-plains --pixel 0.5 --area=-80,-80,320,100 --body mars --out " +
      quoted(map) + " 2>&1");
  ASSERT_EQ(made.status, 0) << made.output;
  mission_ += "[navigation]\nbody = mars\n";
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0", "--map", on_board.string()}), path("log"));
  const ToolResult result = operate(program, "UDP", "uplink " + map.string() + "\n");
  EXPECT_EQ(result.status, 0) << result.output << program.output();
  EXPECT_TRUE(says(result, "done: uplink " + map.string())) << result.output;
  EXPECT_TRUE(says(result, "map_received")) << result.output;
  const std::vector<fs::path> files = files_in(map);
  EXPECT_GE(files.size(), 4U);
  for (const fs::path& file : files) {
    EXPECT_TRUE(test::text_of(on_board / file.filename()) == test::text_of(file)) << file.filename();
  }
  EXPECT_EQ(files_in(on_board).size(), files.size());
}

TEST_F(ConsoleTest, AFolderThatIsNoMapIsNotSent) {
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0"}), path("log"));
  const ToolResult result = operate(program, "UDP", "uplink " + folder_.path().string() + "\n");
  EXPECT_EQ(result.status, 1) << result.output;
  EXPECT_TRUE(says(result, "there is no directory.ilpm in it")) << result.output;
}

TEST_F(ConsoleTest, AFileThatNoFlightTakesIsNotSentAndTheFaultIsNamed) {
  write("wrong.ini", "[overlap]\ntarget_overlap = 8\n");
  write("words.txt", "hello\n");
  // The flight goes by the name.
  write("tile.ini", "ILPT, but by its name it has parameters\n");
  // Alone it contradicts the defaults; what the flight has set may make it right.
  write("contradicts.ini", "[overlap]\ntarget_overlap = 0.5\n");
  RunningProgram program(flight({"--link-udp", "127.0.0.1:0"}), path("log"));
  const ToolResult result =
      operate(program, "UDP",
              "uplink " + path("wrong.ini").string() + "\nuplink " + path("words.txt").string() + "\nuplink " +
                  path("tile.ini").string() + "\nuplink " + path("contradicts.ini").string() + "\n");
  EXPECT_TRUE(says(result, "[overlap] target_overlap = 8: not a number from 0.5 to 0.98")) << result.output;
  EXPECT_TRUE(says(result, "words.txt: line 1: expected [section], key = value")) << result.output;
  EXPECT_TRUE(says(result, "tile.ini: line 1: expected [section], key = value")) << result.output;
  EXPECT_FALSE(says(result, "sent: uplink " + path("wrong.ini").string() + "\n")) << result.output;
  EXPECT_TRUE(says(result, "contradicts.ini: the flight has not taken contradicts.ini")) << result.output;
}

TEST_F(ConsoleTest, AFlightThatEndsIsNoticed) {
  RunningProgram program(flight({"--link-tcp", "127.0.0.1:0"}), path("log"));
  const SocketAddress address = program.address("packets over TCP");
  ASSERT_NE(address.port, 0) << program.output();
  RunningProgram console(
      {ILP_GROUND, "console", "127.0.0.1:" + std::to_string(address.port), "--tcp", "--status", "0.5", "--stay", "60"},
      path("console"));
  for (int i = 0; i < 200 && console.output().find("status: mission") == std::string::npos; ++i) {
    (void)test::run_tool("sleep 0.1");
  }
  EXPECT_NE(program.stop(), -1) << program.output();
  for (int i = 0; i < 100 && console.output().find("closed the connection") == std::string::npos; ++i) {
    (void)test::run_tool("sleep 0.1");
  }
  EXPECT_NE(console.output().find("the flight has closed the connection"), std::string::npos) << console.output();
}

TEST_F(ConsoleTest, WrongInputIsSaid) {
  const auto run = [&](const std::string& words) {
    return test::run_tool(std::string(ILP_GROUND) + " console " + words + " </dev/null 2>&1");
  };
  EXPECT_TRUE(says(run("localhost"), "127.0.0.1:10025")) << run("localhost").output;
  const SocketAddress nobody = test::free_address();
  const ToolResult refused = run("127.0.0.1:" + std::to_string(nobody.port) + " --tcp");
  EXPECT_EQ(refused.status, 1);
  EXPECT_TRUE(says(refused, "connecting to the flight: Connection refused; start the flight")) << refused.output;
  const ToolResult silent = run("127.0.0.1:" + std::to_string(nobody.port) + " --patience 6");
  EXPECT_EQ(silent.status, 1);
  EXPECT_TRUE(says(silent, "nothing has come from the flight: no program listens there")) << silent.output;
  EXPECT_TRUE(says(silent, "no report comes from the flight at 127.0.0.1")) << silent.output;
  write_keys("7 zz\n");
  EXPECT_TRUE(says(run("127.0.0.1:9 --key " + quoted(path("keys"))), "hexadecimal"));
  EXPECT_TRUE(says(run("127.0.0.1:9 --tailoring other"), "standard, fsfw or yamcs"));
}

}  // namespace
}  // namespace ilp
