// A whole operation over real sockets and in real time, against both programs: ping, parameters, captures to the tenth
// of a second, files by CFDP.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "fsw/packets/service_schedule.hpp"
#include "fsw/packets/service_verification.hpp"
#include "hal/clock/utc.hpp"
#include "sim/ground/console/console.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/integration/operated_strip.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/unit/hal/expect_status.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;
using console::Console;
using console::data_of;
using console::function;
using console::Transport;
using Bytes = Console::Bytes;
using test::RunningProgram;

constexpr std::size_t captures = 20;
constexpr TimeNs minor_frame = 100 * ns_per_ms;

std::string text_of(const SocketAddress& address) {
  return "127.0.0.1:" + std::to_string(address.port);
}

/// When the captures are wanted, after the first: a tenth of a second between some of them.
TimeNs offset_of(std::size_t capture) {
  TimeNs offset = 0;
  for (std::size_t i = 1; i <= capture; ++i) offset += (i % 5 < 3 ? 100 : 500) * ns_per_ms;
  return offset;
}

class Operation {
 public:
  explicit Operation(console::ConsoleSettings settings) : console_(std::move(settings)) {}

  void ping() {
    const std::uint32_t request = console_.command(test_service::service, test_service::are_you_alive, {});
    ASSERT_TRUE(console_.listen(20, [&] { return console_.completed(request); })) << "no answer to a ping";
    EXPECT_EQ(console_.verification_of(request), (std::vector<int>{1, 3, 7}));
    EXPECT_EQ(console_.count(test_service::service, test_service::alive), 1U);
  }

  void set_parameter(const char* section, const char* key, double value) {
    const std::size_t index = find_parameter(section, key);
    const std::uint32_t request =
        console_.command(parameter_management::service, parameter_management::set, data_of([&](ByteWriter& out) {
                           out.u16(1);
                           out.u16(parameter_info(index).number);
                           write_value(parameter_info(index).type, value, out);
                         }));
    ASSERT_TRUE(console_.listen(20, [&] { return console_.completed(request); })) << key;
  }

  /// The status report, twice a second.
  void housekeeping_on() {
    constexpr std::uint64_t status = 1;
    const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
    IntervalList intervals;
    EXPECT_TRUE(intervals.push_back({status, 500 * ns_per_ms}));
    ReportList list;
    EXPECT_TRUE(list.push_back(status));
    const auto set =
        console_.command(housekeeping::service, housekeeping::set_interval,
                         data_of([&](ByteWriter& out) { encode_interval_list(tailoring, intervals, out); }));
    const auto enable = console_.command(housekeeping::service, housekeeping::enable,
                                         data_of([&](ByteWriter& out) { encode_report_list(tailoring, list, out); }));
    EXPECT_TRUE(console_.listen(20, [&] {
      return console_.completed(set) && console_.completed(enable) &&
             console_.count(housekeeping::service, housekeeping::report) >= 3;
    })) << "no housekeeping";
  }

  /// Captures, five of them in a telecommand.
  void schedule(const std::vector<UtcNs>& times) {
    for (std::size_t begin = 0; begin < times.size(); begin += 5) {
      const std::size_t count = std::min<std::size_t>(5, times.size() - begin);
      const Bytes data = data_of([&](ByteWriter& out) {
        const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
        encode_insert_head(tailoring, 0, static_cast<std::uint32_t>(count), out);
        for (std::size_t i = begin; i < begin + count; ++i) {
          const Bytes packet =
              console_.build(function_management::service, function_management::perform, function("CAPTURE"));
          requests_.push_back(Console::request_of(packet));
          times_.push_back(times[i]);
          ScheduleItem item{.release = times_.back(), .packet = packet};
          EXPECT_OK(encode_insert_item(tailoring, item, out));
        }
      });
      const std::uint32_t request = console_.command(scheduling::service, scheduling::insert, data);
      ASSERT_TRUE(console_.listen(20, [&] { return console_.completed(request); })) << "not inserted";
    }
  }

  void wait_for_captures() {
    console_.listen(40, [&] {
      return std::all_of(requests_.begin(), requests_.end(), [&](std::uint32_t r) { return console_.completed(r); });
    });
    std::vector<std::uint32_t> order;
    for (const console::Report& report : console_.reports()) {
      const std::uint32_t request = ByteReader(report.data).u32();
      if (report.header.service != verification::service || report.header.subtype != verification::completion) continue;
      if (std::find(requests_.begin(), requests_.end(), request) != requests_.end()) order.push_back(request);
    }
    EXPECT_EQ(order, requests_) << "each reported, in the order of their times";
    for (const std::uint32_t request : requests_) {
      EXPECT_EQ(console_.verification_of(request), (std::vector<int>{1, 3, 7})) << request;
    }
  }

  void end_strip_and_wait_for_products() {
    console_.command(function_management::service, function_management::perform, function("STRIPEND"));
    EXPECT_TRUE(console_.listen(40, [&] { return !products().empty(); })) << "no product came";
    for (const Bytes& product : products()) {
      ASSERT_GT(product.size(), 12U);
      const Bytes signature{0, 0, 0, 12, 'j', 'P', ' ', ' ', 0x0D, 0x0A, 0x87, 0x0A};
      EXPECT_TRUE(std::equal(signature.begin(), signature.end(), product.begin())) << "no JP2 file";
    }
    EXPECT_EQ(console_.cfdp().counts().checksum_failures, 0U);
    EXPECT_EQ(console_.malformed(), 0U);
  }

  [[nodiscard]] const std::vector<UtcNs>& times() const { return times_; }

 private:
  [[nodiscard]] std::vector<Bytes> products() const {
    std::vector<Bytes> found;
    for (const auto& [name, file] : console_.files()) {
      if (name.find(".jp2") != std::string::npos) found.push_back(file);
    }
    return found;
  }

  Console console_;
  std::vector<std::uint32_t> requests_;
  std::vector<UtcNs> times_;
};

/// What the database says of the captures: exposed at their times, to `tolerance`.
void expect_exposed(const fs::path& out, const std::vector<UtcNs>& times, TimeNs tolerance) {
  const std::vector<SettingRecord> settings = test::records_of<SettingRecord>(out);
  const auto epoch = std::find_if(settings.begin(), settings.end(), [](const SettingRecord& setting) {
    return std::string(setting.name) == "link.mission_epoch_s";
  });
  ASSERT_NE(epoch, settings.end());
  const MissionTime mission(epoch->value);
  std::map<std::int64_t, TimeNs> frames;
  for (const FrameRecord& frame : test::records_of<FrameRecord>(out)) frames[frame.id] = frame.time_ns;
  std::vector<CaptureRecord> taken;
  for (const CaptureRecord& capture : test::records_of<CaptureRecord>(out)) {
    if (capture.source == CaptureSource::telecommand) taken.push_back(capture);
  }
  ASSERT_EQ(taken.size(), times.size());
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_EQ(taken[i].requested_ns, mission.mission(times[i])) << i;
    ASSERT_EQ(taken[i].state, CaptureState::exposed) << i;
    EXPECT_LE(std::abs(taken[i].exposed_ns - taken[i].requested_ns), tolerance) << i;
    EXPECT_EQ(frames[taken[i].frame_id], taken[i].exposed_ns) << i;
  }
}

void operate(const RunningProgram& program, const console::ConsoleSettings& settings, const fs::path& out,
             TimeNs tolerance, RunningProgram& to_stop) {
  Operation operation(settings);
  operation.ping();
  if (testing::Test::HasFatalFailure()) FAIL() << program.output();
  operation.set_parameter("acquisition", "capture_min_interval_s", 0.05);
  operation.housekeeping_on();
  const UtcNs first = (utc_now() / ns_per_s + 4) * ns_per_s;
  std::vector<UtcNs> times;
  for (std::size_t i = 0; i < captures; ++i) times.push_back(first + offset_of(i));
  operation.schedule(times);
  operation.wait_for_captures();
  operation.end_strip_and_wait_for_products();
  EXPECT_EQ(to_stop.stop(), 0) << program.output();
  expect_exposed(out, operation.times(), tolerance);
}

const std::vector<std::string> small_scenario = {
    "--set", "camera.width=192", "--set", "camera.height=144", "--set", "camera.fx=165",      "--set", "camera.fy=165",
    "--set", "camera.cx=-1",     "--set", "camera.cy=-1",      "--set", "flight.drift_m_s=12"};

class OperationTest : public testing::Test {
 protected:
  OperationTest() {
    test::write_file(folder_ / "mission.ini", "[acquisition]\ncapture_mode = 2\n");
    fs::create_directories(folder_ / "out");
  }
  [[nodiscard]] fs::path path(const char* name) const { return fs::path(folder_ / name); }

  void fly_sil(std::vector<std::string> more, Transport transport) {
    std::vector<std::string> command = {ILP_SIL, "--real-time",       "--mission", path("mission.ini").string(),
                                        "--out", path("out").string()};
    command.insert(command.end(), small_scenario.begin(), small_scenario.end());
    command.insert(command.end(), more.begin(), more.end());
    RunningProgram program(command, path("log"));
    fly(program, transport, 0);
  }

  void fly(RunningProgram& program, Transport transport, TimeNs tolerance) {
    console::ConsoleSettings settings;
    settings.transport = transport;
    settings.board = program.address(transport == Transport::udp ? "packets over UDP" : "packets over TCP");
    ASSERT_NE(settings.board.port, 0) << program.output();
    if (cfdp_.port != 0) {
      settings.cfdp = program.address("CFDP over UDP");
      settings.cfdp_local = cfdp_;
    }
    operate(program, settings, path("out"), tolerance, program);
  }

  const test::TemporaryFolder folder_;
  SocketAddress cfdp_;
};

TEST_F(OperationTest, OverUdpAgainstTheSimulator) {
  fly_sil({"--link-udp", "127.0.0.1:0"}, Transport::udp);
}

TEST_F(OperationTest, OverTcpAgainstTheSimulator) {
  fly_sil({"--link-tcp", "127.0.0.1:0"}, Transport::tcp);
}

TEST_F(OperationTest, ImagesAreOfTheTimesThatWereCommandedThoughTheFlightBeganWithAnother) {
  test::write_file(path("mission.ini"), "");
  std::vector<std::string> command = {ILP_SIL, "--real-time",        "--scenario", "mars-plains",
                                      "--out", path("out").string(), "--link-udp", "127.0.0.1:0"};
  command.insert(command.end(), small_scenario.begin(), small_scenario.end());
  RunningProgram program(command, path("log"));
  console::ConsoleSettings settings{.board = program.address("packets over UDP")};
  ASSERT_NE(settings.board.port, 0) << program.output();
  Operation operation(settings);
  operation.ping();
  if (testing::Test::HasFatalFailure()) FAIL() << program.output();
  operation.set_parameter("acquisition", "capture_mode", 2);
  // Off the scenario's regular times by most of their distance, and nearer to each other than those.
  const UtcNs first = (utc_now() / ns_per_s + 3) * ns_per_s + 892 * ns_per_ms;
  operation.schedule({first, first + 700 * ns_per_ms, first + 1400 * ns_per_ms});
  operation.wait_for_captures();
  EXPECT_EQ(program.stop(), 0) << program.output();
  expect_exposed(path("out"), operation.times(), 500'000);
}

TEST_F(OperationTest, WithoutAKeyNobodyCommandsAndNothingCountsTwiceOverARestart) {
  const Bytes key(32, 0x42);
  std::string hex;
  for (std::size_t i = 0; i < key.size(); ++i) hex += "42";
  test::write_private_file(path("keys"), "7 " + hex + "\n");
  test::write_file(path("mission.ini"), "[acquisition]\ncapture_mode = 2\n[link]\nauthentication = 1\n");
  std::vector<std::string> command = {ILP_SIL, "--real-time",        "--mission",  path("mission.ini").string(),
                                      "--out", path("out").string(), "--link-udp", "127.0.0.1:0",
                                      "--key", path("keys").string()};
  command.insert(command.end(), small_scenario.begin(), small_scenario.end());
  const auto answered = [&](const RunningProgram& program, std::uint16_t spi, std::uint32_t number, double wait_s) {
    console::ConsoleSettings settings{
        .board = program.address("packets over UDP"), .spi = spi, .key = key, .sequence = number - 1};
    Console console(settings);
    const std::uint32_t request = console.command(test_service::service, test_service::are_you_alive, {});
    return console.listen(wait_s, [&] { return console.completed(request); });
  };
  {
    RunningProgram program(command, path("log"));
    EXPECT_FALSE(answered(program, 0, 1, 1)) << "no key";
    EXPECT_TRUE(answered(program, 7, 101, 20)) << program.output();
    EXPECT_FALSE(answered(program, 7, 101, 1)) << "the number was used";
    program.stop();
  }
  command.emplace_back("--resume");
  RunningProgram program(command, path("log"));
  EXPECT_FALSE(answered(program, 7, 101, 1)) << "the number was used before the restart";
  EXPECT_FALSE(answered(program, 7, 100, 1)) << "so it may have been";
  EXPECT_TRUE(answered(program, 7, 102, 20)) << program.output();
}

#ifdef ILP_ONBOARD
/// Over a recorded strip.
class OnboardOperationTest : public OperationTest {
 protected:
  static constexpr int strip_s = 60;

  void SetUp() override {
    const std::string strip = test::operated_strip(strip_s);
    ASSERT_FALSE(strip.empty());
    test::write_file(path("strip.txt"), strip);
  }

  [[nodiscard]] std::vector<std::string> command() const {
    return {ILP_ONBOARD,  "--trap-heap",
            "--mission",  path("mission.ini").string(),
            "--camera",   test::camera_numbers(test::prepared_flights() / "plain") + " 0 0 0 0",
            "--index",    path("strip.txt").string(),
            "--database", (path("out") / "flight.db").string()};
  }
};

TEST_F(OnboardOperationTest, OverUdpAndWithBarePdus) {
  cfdp_ = test::free_address();
  std::vector<std::string> words = command();
  words.insert(words.end(),
               {"--link-udp", "127.0.0.1:0", "--cfdp-udp", "127.0.0.1:0", "--cfdp-udp-peer", text_of(cfdp_)});
  RunningProgram program(words, path("log"));
  fly(program, Transport::udp, minor_frame);
  EXPECT_NE(program.output().find("heap requests after sealing: 0\n"), std::string::npos) << program.output();
}

TEST_F(OnboardOperationTest, OverTcp) {
  std::vector<std::string> words = command();
  words.insert(words.end(), {"--link-tcp", "127.0.0.1:0"});
  RunningProgram program(words, path("log"));
  fly(program, Transport::tcp, minor_frame);
}
#endif

}  // namespace
}  // namespace ilp
