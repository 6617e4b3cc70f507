// The flight in several processes makes the same records and products as in one, whatever happens to the processes.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>
#include <string>
#include <thread>

#include "hal/store/sqlite/page_checksum.hpp"
#include "hal/store/sqlite/sqlite_store.hpp"
#include "tests/distributed/spread_flight.hpp"
#include "tests/integration/flight_files.hpp"

namespace ilp {
namespace {

using test::SpreadFlight;
using Split = std::vector<std::string>;

const Split two = {"head,overlap_checker,camera_calibrator,structure_and_motion,storage_manager,compressor",
                   "dense_matcher,place_memory,richness_scorer"};
const Split three = {"head,storage_manager", "overlap_checker,camera_calibrator,structure_and_motion",
                     "dense_matcher,richness_scorer,compressor,place_memory"};
const Split each = {"head",         "overlap_checker", "camera_calibrator", "structure_and_motion", "dense_matcher",
                    "place_memory", "richness_scorer", "compressor",        "storage_manager"};

void sleep_ms(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

void expect_same_flight(const Split& split) {
  SpreadFlight flight(split);
  flight.start_all();
  EXPECT_EQ(flight.wait(), std::vector<int>(split.size(), 0)) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
  EXPECT_NE(flight.output(0).find("heap requests after sealing: 0\n"), std::string::npos) << flight.output(0);
}

TEST(SpreadFlight, TwoProcessesMakeTheSame) {
  expect_same_flight(two);
}

TEST(SpreadFlight, ThreeProcessesMakeTheSame) {
  expect_same_flight(three);
}

TEST(SpreadFlight, AProcessForEachStageMakesTheSame) {
  expect_same_flight(each);
}

/// Disturbs the flight until it has ended, and compares.
template <typename Disturb>
void expect_same_in_spite_of(const Split& split, std::uint64_t seed, Disturb disturb) {
  std::mt19937_64 random(seed);
  SpreadFlight flight(split);
  flight.start_all();
  int disturbances = 0;
  for (int waited = 0; !flight.keep_up(); waited += 45) {
    ASSERT_LT(waited, 120'000) << "no end; the head says: " << flight.output(0);
    // Short beside the second or two of a flight, so that a faster machine is disturbed often enough too.
    sleep_ms(20 + static_cast<int>(random() % 50));
    if (disturbances < 12) {
      disturb(flight, random);
      ++disturbances;
    }
  }
  EXPECT_GT(disturbances, 3);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, KilledAgainAndAgainTheProcessesMakeTheSame) {
  for (const std::uint64_t seed : {1U, 2U}) {
    expect_same_in_spite_of(three, seed, [](SpreadFlight& flight, std::mt19937_64& random) {
      const std::size_t process = random() % three.size();
      if (flight.runs(process)) flight.kill(process);
    });
  }
}

/// What a power cut leaves of a database's log: what the mark says, and nothing of what came later.
void cut_power(const std::string& store) {
  test::Bytes mark = test::read_file(store + "-sync");
  test::Bytes log = test::read_file(store + "-wal");
  if (mark.size() < 16 || log.size() <= log_header_bytes) return;
  const bool same_log = std::equal(mark.begin(), mark.begin() + 8, log.begin() + 16);
  std::size_t frames = 0;
  // The highest bit is a flag.
  for (std::size_t k = 0; k < 7; ++k) frames |= static_cast<std::size_t>(mark[8 + k]) << 8 * k;
  const std::size_t kept = log_header_bytes + (same_log ? frames * frame_bytes : 0);
  std::fill(log.begin() + static_cast<std::ptrdiff_t>(std::min(kept, log.size())), log.end(), std::uint8_t{0});
  test::write_file(store + "-wal", std::string(log.begin(), log.end()));
}

/// Products that were sent, and that the database knows nothing of; it is opened as a copy.
std::string sent_but_lost(const SpreadFlight& flight) {
  const auto copy = flight.folder() / "copy";
  std::filesystem::create_directories(copy);
  for (const char* suffix : {"", "-wal", "-sync"}) {
    // A database whose last process has closed it has neither a log nor a mark.
    if (!std::filesystem::exists(flight.store() + suffix)) continue;
    std::filesystem::copy_file(flight.store() + suffix, (copy / "flight.db").string() + suffix,
                               std::filesystem::copy_options::overwrite_existing);
  }
  SqliteStore store;
  if (!store.open((copy / "flight.db").c_str()).ok()) return "the database cannot be opened";
  std::string lost;
  for (const auto& [name, bytes] : test::files_of(flight.folder() / "outbox", {"product-"})) {
    const bool image = name.find("-image.jp2") != std::string::npos;
    if (name.find(".part") != std::string::npos || (!image && name.find("-depth.jp2") == std::string::npos)) continue;
    ProductRecord product;
    const std::int64_t keyframe = std::stoll(name.substr(8, 6));
    if (!get(store, product_id(keyframe, image ? ProductKind::image : ProductKind::depth), product).ok()) {
      lost += name + " ";
    }
  }
  store.close();
  std::filesystem::remove_all(copy);
  return lost;
}

TEST(SpreadFlight, AfterPowerCutsTheProcessesMakeTheSameAndWhatWasSentIsThere) {
  if (SpreadFlight::on_server()) GTEST_SKIP() << "the log is that of a database file";
  std::mt19937_64 random(6);
  int cuts = 0;
  for (int round = 0; round < 2; ++round) {
    SpreadFlight flight(three);
    flight.start_all();
    // The power is cut by what was sent, not by the clock: a machine of any speed gets the same number of cuts. Before
    // the first product there is nothing to lose.
    std::size_t next_cut = 1;
    for (int waited = 0; !flight.keep_up(); waited += 2) {
      ASSERT_LT(waited, 60'000) << "no end; the head says: " << flight.output(0);
      sleep_ms(2);
      const std::size_t sent = flight.files_sent();
      if (sent < next_cut || cuts >= 5 * (round + 1)) continue;
      sleep_ms(static_cast<int>(random() % 8));
      for (std::size_t process = 0; process < three.size(); ++process) {
        if (flight.runs(process)) flight.kill(process);
      }
      cut_power(flight.store());
      ++cuts;
      next_cut = sent + 1 + random() % 2;
      EXPECT_EQ(sent_but_lost(flight), "");
      // Processes that had ended in order are started too: the database may have lost the end of the flight.
      flight.start_all();
    }
    EXPECT_EQ(flight.digest(), test::digest_of_one_process());
  }
  EXPECT_GE(cuts, 3);
}

TEST(SpreadFlight, AProcessThatHangsForAWhileLosesNothing) {
  expect_same_in_spite_of(three, 3, [](SpreadFlight& flight, std::mt19937_64& random) {
    const std::size_t process = random() % three.size();
    if (!flight.runs(process)) return;
    flight.freeze(process);
    sleep_ms(300);
    flight.thaw(process);
  });
}

TEST(SpreadFlight, ProcessesThatAreStoppedInTransactionsAreEndedAndTheFlightIsTheSame) {
  if (SpreadFlight::on_server()) GTEST_SKIP() << "the lock is that of a database file";
  std::mt19937_64 random(7);
  int stopped = 0;
  // A flight may be over before it was stopped often enough.
  for (int round = 0; round < 6 && stopped < 4; ++round) {
    SpreadFlight flight(three);
    flight.lease(1);
    flight.start_all();
    std::size_t here = 0;
    for (int waited = 0; !flight.keep_up(); waited += 2) {
      ASSERT_LT(waited, 120'000) << "no end; the head says: " << flight.output(0);
      sleep_ms(2);
      const std::size_t node = 1 + random() % 2;
      if (here >= 3 || !flight.runs(node) || flight.output(node).find("running ") == std::string::npos) continue;
      if (!flight.freeze_in_transaction(node)) continue;
      // Nobody but the primary can end it.
      for (int k = 0; k < 30'000 && flight.runs(node) && flight.runs(0); ++k) sleep_ms(2);
      ASSERT_FALSE(flight.runs(node) && flight.runs(0)) << flight.output(0);
      if (!flight.runs(node)) ++here;
    }
    EXPECT_EQ(flight.digest(), test::digest_of_one_process());
    std::size_t named = 0;
    for (const EventRecord& event : test::records_of<EventRecord>(flight.folder())) {
      named += event.code == static_cast<std::uint16_t>(StatusCode::lock_holder) && event.b == 1 ? 1 : 0;
    }
    EXPECT_GE(named, here);
    stopped += static_cast<int>(here);
  }
  EXPECT_GE(stopped, 3);
}

TEST(SpreadFlight, WhileAnotherProgramKeepsTheLockTheFlightWaitsAndIsTheSame) {
  if (SpreadFlight::on_server()) GTEST_SKIP() << "the lock is that of a database file";
  SpreadFlight flight(two);
  flight.lease(1);
  flight.start_all();
  int kept = 0;
  for (int waited = 0; !flight.keep_up(); waited += 2) {
    ASSERT_LT(waited, 120'000) << "no end; the head says: " << flight.output(0);
    sleep_ms(2);
    if (flight.files_sent() < static_cast<std::size_t>(2 * kept + 1) || kept >= 2) continue;
    SqliteStore other;
    ASSERT_TRUE(other.open(flight.store().c_str()).ok());
    ASSERT_TRUE(other.synchronise(Synchronise::later).ok());
    if (!other.begin().ok()) continue;
    ++kept;
    const std::string name = "process " + std::to_string(::getpid()) + " kept the writers' lock";
    for (int k = 0; k < 30'000 && flight.output(0).find(name) == std::string::npos; ++k) sleep_ms(2);
    EXPECT_NE(flight.output(0).find(name), std::string::npos) << flight.output(0);
    // Longer than transactions are waited for.
    sleep_ms(kept == 1 ? 2500 : 0);
    other.rollback();
  }
  EXPECT_EQ(kept, 2);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, AStageRunsInOneProcess) {
  SpreadFlight flight(two);
  flight.start(0);
  flight.start(1);
  for (int k = 0; k < 200 && flight.output(1).find("running ") == std::string::npos; ++k) sleep_ms(50);
  for (const std::string taken : {"dense_matcher", "compressor,dense_matcher", "compressor"}) {
    const test::ProgramResult second = test::run_program(flight.node_command(taken));
    EXPECT_EQ(second.exit_status, 1) << second.output;
    EXPECT_NE(second.output.find("is run by another process"), std::string::npos) << second.output;
  }
  EXPECT_EQ(flight.wait(), (std::vector<int>{0, 0})) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, ASecondPrimaryIsRefused) {
  SpreadFlight flight(two);
  // Without the other process the flight does not end. The primary opens its nonvolatile memory when it has its stages.
  flight.start(0);
  for (int k = 0; k < 1000 && !std::filesystem::exists(flight.folder() / "state.keep-1"); ++k) sleep_ms(50);
  const test::ProgramResult second = test::run_program(flight.primary_command("-of-another"));
  EXPECT_EQ(second.exit_status, 1) << second.output;
  EXPECT_NE(second.output.find("is run by another process"), std::string::npos) << second.output;
  flight.start(1);
  EXPECT_EQ(flight.wait(), (std::vector<int>{0, 0})) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, AProcessWithAnotherMissionIsRefused) {
  SpreadFlight flight(two);
  flight.start(0);
  const auto mission = flight.folder() / "other.ini";
  test::write_file(mission, "[overlap]\ntarget_overlap = 0.85\n");
  const test::ProgramResult other = test::run_program(flight.node_command(two[1], {"--mission", mission.string()}));
  EXPECT_EQ(other.exit_status, 1) << other.output;
  EXPECT_NE(other.output.find("differs from the flight that it joins"), std::string::npos) << other.output;
  flight.start(1);
  EXPECT_EQ(flight.wait(), (std::vector<int>{0, 0})) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST(SpreadFlight, WhatCannotRunByItselfIsSaid) {
  const SpreadFlight flight(two);
  const test::ProgramResult part = test::run_program(flight.node_command("acquisition"));
  EXPECT_EQ(part.exit_status, 2);
  EXPECT_NE(part.output.find("\"acquisition\" is no stage that can run by itself"), std::string::npos) << part.output;
  EXPECT_NE(part.output.find("dense_matcher"), std::string::npos) << part.output;
}

}  // namespace
}  // namespace ilp
