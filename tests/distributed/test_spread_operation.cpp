// The ground operates a flight in several processes, in real time.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <memory>

#include "cfg/schedule.hpp"
#include "fsw/packets/report_table.hpp"
#include "fsw/packets/service_housekeeping.hpp"
#include "fsw/packets/service_verification.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "sim/ground/console/console.hpp"
#include "sim/ground/console/telecommand_data.hpp"
#include "tests/distributed/stopped_program.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/integration/operated_strip.hpp"
#include "tests/integration/running_program.hpp"
#include "tests/unit/hal/temporary_folder.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;
using console::Console;
using console::data_of;
using console::function;
using test::RunningProgram;

constexpr std::uint8_t nodes_report = 21;
constexpr int lease_s = 10;
constexpr std::uint8_t matcher = static_cast<std::uint8_t>(ComponentId::dense_matcher);

class SpreadOperation : public testing::Test {
 protected:
  void SetUp() override {
    const std::string strip = test::operated_strip(120);
    ASSERT_FALSE(strip.empty());
    test::write_file(folder_ / "strip.txt", strip);
    start_node();
    primary_ = std::make_unique<RunningProgram>(
        std::vector<std::string>{ILP_ONBOARD, "--trap-heap", "--stages",
                                 "head,overlap_checker,camera_calibrator,structure_and_motion,storage_manager",
                                 "--camera", test::camera_numbers(test::prepared_flights() / "plain") + " 0 0 0 0",
                                 "--index", folder_ / "strip.txt", "--store", store(), "--link-udp", "127.0.0.1:0",
                                 "--lock-lease", std::to_string(lease_s)},
        folder_ / "head");
    console::ConsoleSettings settings{.board = primary_->address("packets over UDP")};
    ASSERT_NE(settings.board.port, 0) << primary_->output();
    console_ = std::make_unique<Console>(settings);
  }
  void start_node() {
    node_ = std::make_unique<RunningProgram>(
        std::vector<std::string>{ILP_ONBOARD, "--trap-heap", "--stages",
                                 "dense_matcher,place_memory,richness_scorer,compressor", "--store", store()},
        folder_ / "node");
  }
  [[nodiscard]] std::string store() const { return folder_ / "flight.db"; }

  bool ping() { return done(console_->command(17, 1, {})); }
  bool failed(std::uint32_t request) {
    return console_->listen(30, [&] {
      const std::vector<int> verified = console_->verification_of(request);
      return std::find(verified.begin(), verified.end(), verification::start_failed) != verified.end();
    });
  }
  /// Reports of the package's status, one in each second.
  void enable_housekeeping() {
    const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
    EXPECT_TRUE(done(console_->command(housekeeping::service, 31, data_of([](ByteWriter& out) {
                                         for (const auto& [value, octets] : {std::pair{1, 2}, {1, 1}, {1000, 4}}) {
                                           out.number(static_cast<std::uint64_t>(value),
                                                      static_cast<std::size_t>(octets));
                                         }
                                       }))));
    ReportList list;
    EXPECT_TRUE(list.push_back(1));
    EXPECT_TRUE(done(console_->command(housekeeping::service, 5,
                                       data_of([&](ByteWriter& out) { encode_report_list(tailoring, list, out); }))));
  }
  bool receive_housekeeping(std::size_t reports) {
    const std::size_t before = console_->count(housekeeping::service, housekeeping::report);
    return console_->listen(
        60, [&] { return console_->count(housekeeping::service, housekeeping::report) >= before + reports; });
  }
  [[nodiscard]] std::vector<FrameRecord> frames() const {
    return test::records_of<FrameRecord>(fs::path(store()).parent_path());
  }
  bool done(std::uint32_t request) {
    return console_->listen(30, [&] { return console_->completed(request); });
  }
  /// How many processes the flight reports, as soon as it is `count`, or after 20 s.
  std::size_t processes(std::size_t count) {
    std::size_t found = 0;
    for (int attempt = 0; attempt < 20 && found != count; ++attempt) {
      const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
      ReportList list;
      EXPECT_TRUE(list.push_back(nodes_report));
      const std::size_t before = console_->count(housekeeping::service, housekeeping::report);
      console_->command(housekeeping::service, housekeeping::report_once,
                        data_of([&](ByteWriter& out) { encode_report_list(tailoring, list, out); }));
      EXPECT_TRUE(
          console_->listen(10, [&] { return console_->count(housekeeping::service, housekeeping::report) > before; }));
      found = 0;
      for (const console::Report& report : console_->reports()) {
        if (report.header.service == housekeeping::service) found = processes_of(report);
      }
      console_->listen(1, [] { return false; });
    }
    return found;
  }
  static std::size_t processes_of(const console::Report& report) {
    const std::size_t one = report_bytes(*find_report(nodes_report)) / most_nodes;
    std::size_t processes = 0;
    for (std::size_t at = 1; at + one <= report.data.size(); at += one) {
      const auto begin = report.data.begin() + static_cast<std::ptrdiff_t>(at);
      processes += std::any_of(begin, begin + 4, [](std::uint8_t octet) { return octet != 0; }) ? 1 : 0;
    }
    return processes;
  }
  /// How often an event with this first value is on record.
  [[nodiscard]] std::size_t events(StatusCode code, std::int64_t a) const {
    const std::vector<EventRecord> all = test::records_of<EventRecord>(fs::path(store()).parent_path());
    return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [&](const EventRecord& event) {
      return event.code == static_cast<std::uint16_t>(code) && event.a == a;
    }));
  }
  bool wait_for_event(StatusCode code, std::int64_t a, std::size_t count) {
    return console_->listen(30, [&] { return events(code, a) >= count; });
  }

  const test::TemporaryFolder folder_;
  std::unique_ptr<RunningProgram> primary_, node_;
  std::unique_ptr<Console> console_;
};

TEST_F(SpreadOperation, TheGroundSeesAndCommandsStagesOfAnotherProcess) {
  EXPECT_EQ(processes(2), 2U) << primary_->output() << node_->output();
  EXPECT_TRUE(wait_for_event(StatusCode::node_joined, matcher, 1));

  const std::uint32_t restart = console_->command(8, 1, function("RESTART", {matcher}));
  EXPECT_TRUE(done(restart)) << primary_->output();
  EXPECT_TRUE(wait_for_event(StatusCode::component_restarted, matcher, 1)) << node_->output();

  node_->send(SIGKILL);
  node_->wait();
  EXPECT_TRUE(wait_for_event(StatusCode::node_silent, matcher, 1));
  start_node();
  EXPECT_TRUE(wait_for_event(StatusCode::node_joined, matcher, 2)) << node_->output();

  EXPECT_EQ(node_->stop(), 0) << node_->output();
  EXPECT_EQ(primary_->stop(), 0) << primary_->output();
  EXPECT_FALSE(test::records_of<DepthRecord>(fs::path(store()).parent_path()).empty()) << "the process worked";
  EXPECT_NE(primary_->output().find("heap requests after sealing: 0\n"), std::string::npos) << primary_->output();
}

TEST_F(SpreadOperation, WhileAnotherProgramKeepsTheLockThePingIsAnsweredAndAllGoesOnAfterwards) {
  enable_housekeeping();
  SqliteStore other;
  ASSERT_TRUE(other.open(store().c_str()).ok());
  ASSERT_TRUE(other.begin().ok());
  const std::size_t before = frames().size();
  for (int k = 0; k < 5; ++k) EXPECT_TRUE(ping()) << k << primary_->output();
  EXPECT_TRUE(receive_housekeeping(3));
  EXPECT_TRUE(failed(console_->command(8, 1, function("FLUSH"))));
  EXPECT_TRUE(ping());
  const std::string name = "process " + std::to_string(::getpid()) + " kept the writers' lock";
  EXPECT_TRUE(console_->listen(60, [&] { return primary_->output().find(name) != std::string::npos; }))
      << primary_->output();
  EXPECT_TRUE(ping());
  EXPECT_TRUE(receive_housekeeping(1));
  EXPECT_LE(frames().size(), before + 1) << "nothing was stored";
  other.rollback();
  other.close();

  EXPECT_TRUE(wait_for_event(StatusCode::lock_holder, ::getpid(), 1)) << primary_->output();
  EXPECT_TRUE(console_->listen(60, [&] { return frames().size() > before + 50; })) << "images are taken again";
  EXPECT_TRUE(done(console_->command(8, 1, function("FLUSH")))) << primary_->output();
  EXPECT_TRUE(node_->runs()) << node_->output();
  EXPECT_EQ(node_->stop(), 0) << node_->output();
  EXPECT_EQ(primary_->stop(), 0) << primary_->output();
  // A recorded strip waits for the lock, so that nothing of it is lost.
  std::int64_t id = 0;
  for (const FrameRecord& frame : frames()) EXPECT_EQ(frame.id, ++id);
  EXPECT_EQ(test::events_of(fs::path(store()).parent_path(), StatusCode::frame_gap), 0U);
  EXPECT_EQ(test::events_of(fs::path(store()).parent_path(), StatusCode::store_locked), 1U);
  EXPECT_EQ(test::events_of(fs::path(store()).parent_path(), StatusCode::events_lost), 0U);
}

TEST_F(SpreadOperation, WhileANodeIsStoppedInATransactionThePingIsAnsweredUntilItIsEnded) {
  EXPECT_TRUE(wait_for_event(StatusCode::node_joined, matcher, 1)) << node_->output();
  enable_housekeeping();
  ASSERT_TRUE(test::stop_in_transaction(*node_, store(), 30'000'000));
  const int stopped = node_->process();
  EXPECT_TRUE(ping()) << primary_->output();
  EXPECT_TRUE(receive_housekeeping(1));
  EXPECT_TRUE(node_->runs()) << "answered in spite of it";
  EXPECT_EQ(node_->wait(), -1);
  EXPECT_FALSE(node_->runs()) << "the head has ended it";
  EXPECT_TRUE(wait_for_event(StatusCode::lock_holder, stopped, 1)) << primary_->output();
  const std::size_t before = frames().size();
  start_node();
  EXPECT_TRUE(wait_for_event(StatusCode::node_joined, matcher, 2)) << node_->output();
  EXPECT_TRUE(console_->listen(60, [&] { return frames().size() > before; }));
  EXPECT_EQ(node_->stop(), 0) << node_->output();
  EXPECT_EQ(primary_->stop(), 0) << primary_->output();
}

}  // namespace
}  // namespace ilp
