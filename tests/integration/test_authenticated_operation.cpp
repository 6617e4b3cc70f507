// Authentication of telecommands and of files, end to end: the flight program, our console, and an attacker between
// them who records everything and says it again.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "cfg/mission.hpp"
#include "fsw/packets/service_verification.hpp"
#include "hal/posix/socket_address.hpp"
#include "sim/ground/console/console.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/integration/operated_strip.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/support/socket_client.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;
using console::Console;
using console::function;
using Bytes = Console::Bytes;
using test::RunningProgram;

constexpr std::uint16_t spi = 7;
constexpr double patience_s = 40;
const Bytes key(32, 0x42);

/// Stands between station and board, hands everything on and keeps what the station sent.
class Eavesdropper {
 public:
  Eavesdropper() {
    EXPECT_TRUE(open_socket(SocketKind::udp, test::any_port, to_station_).ok());
    EXPECT_TRUE(open_socket(SocketKind::udp, test::any_port, to_board_).ok());
    EXPECT_TRUE(local_address(to_station_, address_).ok());
    thread_ = std::thread([this] { work(); });
  }
  ~Eavesdropper() {
    ended_ = true;
    thread_.join();
    close_socket(to_station_);
    close_socket(to_board_);
  }
  Eavesdropper(const Eavesdropper&) = delete;
  Eavesdropper& operator=(const Eavesdropper&) = delete;

  [[nodiscard]] SocketAddress address() const { return address_; }
  void board_is(const SocketAddress& board) {
    const std::lock_guard lock(mutex_);
    board_ = board;
  }
  std::vector<Bytes> received() {
    const std::lock_guard lock(mutex_);
    return received_;
  }

 private:
  void work() {
    pollfd sockets[2] = {{to_station_, POLLIN, 0}, {to_board_, POLLIN, 0}};
    while (!ended_) {
      if (::poll(sockets, 2, 20) <= 0) continue;
      if ((sockets[0].revents & POLLIN) != 0) from_station();
      if ((sockets[1].revents & POLLIN) != 0) from_board();
    }
  }
  void from_station() {
    sockaddr_in sender{};
    const Bytes octets = take(to_station_, sender);
    const std::lock_guard lock(mutex_);
    station_ = sender;
    received_.push_back(octets);
    const sockaddr_in to = system_address(board_);
    ::sendto(to_board_, octets.data(), octets.size(), 0, general(&to), sizeof(to));
  }
  void from_board() {
    sockaddr_in sender{};
    const Bytes octets = take(to_board_, sender);
    if (station_.sin_port == 0) return;
    ::sendto(to_station_, octets.data(), octets.size(), 0, general(&station_), sizeof(station_));
  }
  static Bytes take(int socket, sockaddr_in& sender) {
    Bytes octets(65536);
    socklen_t size = sizeof(sender);
    const ssize_t got = ::recvfrom(socket, octets.data(), octets.size(), MSG_DONTWAIT, general(&sender), &size);
    octets.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
    return octets;
  }

  int to_station_ = -1, to_board_ = -1;
  SocketAddress address_, board_;
  sockaddr_in station_{};
  std::mutex mutex_;
  std::vector<Bytes> received_;
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

class AuthenticatedOperationTest : public testing::Test {
 protected:
  void SetUp() override {
    test::write_file(path("mission.ini"), "[acquisition]\ncapture_mode = 2\n[link]\nauthentication = 2\n");
    std::string hex;
    for (std::size_t i = 0; i < key.size(); ++i) hex += "42";
    test::write_private_file(path("keys"), std::to_string(spi) + " " + hex + "\n");
    fs::create_directories(path("out"));
    write_strip();
  }
  [[nodiscard]] fs::path path(const char* name) const { return fs::path(folder_ / name); }

  void write_strip() {
    const std::string strip = test::operated_strip(600);
    ASSERT_FALSE(strip.empty());
    test::write_file(path("strip.txt"), strip);
  }

  std::unique_ptr<RunningProgram> begin() {
    auto program = std::make_unique<RunningProgram>(
        std::vector<std::string>{ILP_ONBOARD, "--fly-on", "--mission", path("mission.ini").string(), "--camera",
                                 test::camera_numbers(test::prepared_flights() / "plain") + " 0 0 0 0", "--index",
                                 path("strip.txt").string(), "--database", (path("out") / "flight.db").string(),
                                 "--link-udp", "127.0.0.1:0", "--key", path("keys").string()},
        path("log"));
    board_ = program->address("packets over UDP");
    EXPECT_NE(board_.port, 0) << program->output();
    between_.board_is(board_);
    return program;
  }
  /// A station that goes on with its numbers.
  std::unique_ptr<Console> station() {
    console::ConsoleSettings settings;
    settings.board = between_.address();
    settings.spi = spi;
    settings.key = key;
    settings.seal_files = true;
    settings.numbers = std::make_shared<console::StationNumbers>(path("numbers"));
    return std::make_unique<Console>(settings);
  }
  static bool answered(Console& console, std::uint32_t request, double seconds = patience_s) {
    return console.listen(seconds, [&] { return console.completed(request); });
  }
  static bool ping(Console& console, double seconds = patience_s) {
    return answered(console, console.command(17, 1, {}), seconds);
  }
  static std::uint32_t call(Console& console, const char* name, const Bytes& arguments = {}) {
    return console.command(8, 1, function(name, arguments));
  }
  static bool uplink(Console& console, const char* name, const std::string& text) {
    const std::uint64_t transfer = console.put_file(name, Bytes(text.begin(), text.end()));
    return console.listen(patience_s,
                          [&] { return console.transfer(transfer).state == ground_cfdp::CfdpSender::State::retained; });
  }
  /// Everything that was ever sent, from another place.
  void say_everything_again() {
    test::UdpClient thief(board_);
    for (const Bytes& octets : between_.received()) thief.send(octets);
    EXPECT_FALSE(thief.receive(1500).has_value()) << "who only repeats is not answered";
  }
  /// Telecommands and files without a key, and with another one.
  void forge() {
    for (const bool with_key : {false, true}) {
      console::ConsoleSettings settings;
      settings.board = board_;
      settings.spi = with_key ? spi : 0;
      settings.key = Bytes(32, 0x43);
      settings.seal_files = with_key;
      settings.sequence = 4'000'000'000U;
      Console forger(settings);
      const std::string text = "[overlap]\nselection_slack = 0.2\n";
      const std::uint64_t transfer = forger.put_file("forged.ini", Bytes(text.begin(), text.end()));
      const std::uint32_t request = call(forger, "CAPTURE");
      EXPECT_FALSE(answered(forger, request, 1.5)) << with_key;
      EXPECT_EQ(forger.transfer(transfer).state, ground_cfdp::CfdpSender::State::going);
      EXPECT_TRUE(forger.reports().empty()) << "telemetry goes to those who have a key";
    }
  }
  std::size_t commanded_captures() const {
    std::size_t count = 0;
    for (const CaptureRecord& capture : test::records_of<CaptureRecord>(path("out"))) {
      count += capture.source == CaptureSource::telecommand ? 1U : 0U;
    }
    return count;
  }

  const test::TemporaryFolder folder_;
  Eavesdropper between_;
  SocketAddress board_;
};

TEST_F(AuthenticatedOperationTest, EverythingArrivesBothWaysOverRestartsAndNothingForgedOrRepeatedIsTaken) {
  auto program = begin();
  auto console = station();
  ASSERT_TRUE(ping(*console)) << program->output();
  forge();
  // Images, and their products down.
  constexpr std::size_t captures = 4;
  for (std::size_t i = 0; i < captures; ++i) {
    EXPECT_TRUE(answered(*console, call(*console, "CAPTURE"))) << i;
    console->listen(0.6);
  }
  EXPECT_TRUE(answered(*console, call(*console, "STRIPEND")));
  const auto product_came = [&] {
    for (const auto& [name, file] : console->files()) {
      if (name.find(".jp2") != std::string::npos) return true;
    }
    return false;
  };
  EXPECT_TRUE(console->listen(patience_s, product_came)) << "no product came";
  // A file up, and in force.
  EXPECT_TRUE(uplink(*console, "slack.ini", "[overlap]\nselection_slack = 0.05\n"));
  EXPECT_TRUE(answered(*console, call(*console, "ACTIVATE", {0, 0, 0, 1})));
  say_everything_again();
  EXPECT_TRUE(ping(*console));

  EXPECT_EQ(program->stop(), 0) << program->output();
  program = begin();
  say_everything_again();
  EXPECT_TRUE(ping(*console)) << "over a restart of the board; " << program->output();
  EXPECT_TRUE(uplink(*console, "sad.ini", "[overlap]\noverlap_sad = 1\n"));

  console.reset();
  console = station();
  EXPECT_TRUE(ping(*console)) << "over a restart of the station";
  EXPECT_TRUE(uplink(*console, "corners.ini", "[motion]\ncorners = 900\n"));
  forge();
  say_everything_again();
  EXPECT_EQ(program->stop(), 0) << program->output();

  EXPECT_EQ(commanded_captures(), captures) << "each once, and nobody else's";
  std::vector<std::string> names;
  for (const UplinkRecord& record : test::records_of<UplinkRecord>(path("out"))) names.emplace_back(record.name);
  EXPECT_EQ(names, (std::vector<std::string>{"slack.ini", "sad.ini", "corners.ini"}));
  for (const SettingRecord& setting : test::records_of<SettingRecord>(path("out"))) {
    if (std::string(setting.name) == "overlap.selection_slack") {
      EXPECT_EQ(setting.value, 0.05);
    }
  }
  EXPECT_GE(test::events_of(path("out"), StatusCode::telecommands_refused), 1U);
  // What the station holds is released; an open product would mean that its receipt was not accepted.
  EXPECT_FALSE(test::records_of<DownlinkRecord>(path("out")).empty());
  for (const ProductRecord& product : test::records_of<ProductRecord>(path("out"))) {
    EXPECT_EQ(product.state, ProductState::acknowledged) << product.id;
  }
}

TEST_F(AuthenticatedOperationTest, WhatWasSaidBeforeADatabaseWasSetAsideIsNotTakenAfterwards) {
  auto program = begin();
  auto console = station();
  ASSERT_TRUE(ping(*console)) << program->output();
  EXPECT_TRUE(answered(*console, call(*console, "CAPTURE")));
  EXPECT_TRUE(uplink(*console, "slack.ini", "[overlap]\nselection_slack = 0.05\n"));
  // Everything that was sent before has arrived.
  EXPECT_TRUE(ping(*console));
  program->stop();

  for (const char* end : {"-wal", "-shm"}) fs::remove(path("out") / (std::string("flight.db") + end));
  std::ofstream(path("out") / "flight.db", std::ios::binary | std::ios::trunc) << std::string(20'000, 'x');
  program = begin();
  say_everything_again();
  EXPECT_TRUE(ping(*console)) << program->output();
  EXPECT_TRUE(uplink(*console, "sad.ini", "[overlap]\noverlap_sad = 1\n"));
  say_everything_again();
  program->stop();

  EXPECT_EQ(test::events_of(path("out"), StatusCode::store_set_aside), 1U);
  EXPECT_EQ(commanded_captures(), 0U) << "the telecommand of the store epoch before";
  const auto uplinks = test::records_of<UplinkRecord>(path("out"));
  ASSERT_EQ(uplinks.size(), 1U);
  EXPECT_STREQ(uplinks[0].name, "sad.ini");
}

}  // namespace
}  // namespace ilp
