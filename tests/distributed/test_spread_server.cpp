// What happens to the database server of a flight in several processes. Runs with tests/distributed/with_postgres.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <thread>

#include "cfg/limits.hpp"
#include "tests/distributed/spread_flight.hpp"
#include "tests/integration/flight_files.hpp"
#include "tests/unit/hal/small_disk.hpp"

namespace ilp {
namespace {

using test::SpreadFlight;

const std::vector<std::string> three = {"head,storage_manager",
                                        "overlap_checker,camera_calibrator,structure_and_motion",
                                        "dense_matcher,richness_scorer,compressor,place_memory"};

/// Of 50 ms.
constexpr int patience_looks = 2400;

void sleep_ms(int milliseconds) {
  std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
}

test::ProgramResult server(const std::string& order) {
  return test::run_program({std::getenv("ILP_POSTGRES_SERVER"), order});
}

class SpreadServer : public testing::Test {
 protected:
  void SetUp() override {
    if (!SpreadFlight::on_server()) GTEST_SKIP() << "run it with tests/distributed/with_postgres";
  }
  /// Flies to the end, and does this whenever the flight has sent another file, at most `most` times.
  template <typename Disturb>
  static int disturb_until_the_end(SpreadFlight& flight, int most, Disturb disturb) {
    flight.start_all();
    int disturbances = 0;
    std::size_t sent = 0;
    for (int looks = 0; !flight.keep_up(); ++looks) {
      if (looks == 30'000) {
        ADD_FAILURE() << "no end; the head says: " << flight.output(0);
        break;
      }
      sleep_ms(4);
      if (disturbances == most || flight.files_sent() <= sent) continue;
      sent = flight.files_sent();
      disturb();
      ++disturbances;
    }
    return disturbances;
  }
  template <typename Disturb>
  static void expect_same_in_spite_of(Disturb disturb) {
    SpreadFlight flight(three);
    EXPECT_GE(disturb_until_the_end(flight, 4, disturb), 3);
    EXPECT_EQ(flight.digest(), test::digest_of_one_process());
    EXPECT_NE(flight.output(0).find("connected to the store again"), std::string::npos) << flight.output(0);
  }
};

TEST_F(SpreadServer, RestartedItIsConnectedAgainAndTheFlightIsTheSame) {
  expect_same_in_spite_of([] { EXPECT_EQ(server("restart").exit_status, 0); });
}

TEST_F(SpreadServer, KilledItLosesNothingThatWasCommitted) {
  expect_same_in_spite_of([] {
    server("kill");
    sleep_ms(200);
    EXPECT_EQ(server("start").exit_status, 0);
  });
}

/// The number behind `before` in the text; -1 if it is not there.
long long number_behind(const std::string& text, const std::string& before) {
  const std::size_t at = text.find(before);
  return at == std::string::npos ? -1 : std::strtoll(text.c_str() + at + before.size(), nullptr, 10);
}

TEST_F(SpreadServer, ItsLibraryStaysWithinItsMemoryAndNothingElseAllocates) {
  SpreadFlight flight(three);
  flight.start_all();
  EXPECT_EQ(flight.wait(), std::vector<int>(three.size(), 0)) << flight.output(0);
  const std::string said = flight.output(0);
  const long long peak = number_behind(said, "PostgreSQL: peak ");
  EXPECT_GT(peak, 16384) << "the connection lives in this region: " << said;
  EXPECT_LT(peak, static_cast<long long>(limits::postgres_heap_bytes) / 2) << said;
  EXPECT_EQ(number_behind(said, "PostgreSQL: peak " + std::to_string(peak) + " of "),
            static_cast<long long>(limits::postgres_heap_bytes));
  EXPECT_EQ(number_behind(said, "heap requests after sealing: "), 0) << said;
}

TEST_F(SpreadServer, WithoutAnyNotificationTheFlightIsTheSame) {
  SpreadFlight flight(three);
  // The tables are made first, so that the role may be given a function of its own in front of the server's.
  ASSERT_EQ(test::run_program({ILP_STORE, "create", flight.store()}).exit_status, 0);
  const test::ProgramResult suppressed = flight.sql(
      "CREATE FUNCTION public.pg_notify(text, text) RETURNS void LANGUAGE sql AS 'SELECT';\n"
      "ALTER ROLE ilp IN DATABASE " +
      flight.database() + " SET search_path = public, pg_catalog;\n");
  ASSERT_EQ(suppressed.exit_status, 0) << suppressed.output;
  flight.start_all();
  EXPECT_EQ(flight.wait(), std::vector<int>(three.size(), 0)) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST_F(SpreadServer, AHostileClientCostsTimeAndNothingElse) {
  SpreadFlight flight(three);
  int attacks = 0;
  // It keeps the writers' lock, announces what is not so, moves the counters, and ends the others' sessions.
  const auto attack = [&] {
    ++attacks;
    const test::ProgramResult result = flight.sql(
        "SELECT pg_advisory_lock(4803664, 0), pg_sleep(0.5);\n"
        "NOTIFY ilp, '9223372036854775807 -1'; NOTIFY ilp, 'nonsense'; NOTIFY ilp;\n"
        "UPDATE ilp_store SET commits = commits + 3, frame = 0;\n" +
        std::string(attacks % 2 == 0 ? "SELECT count(pg_terminate_backend(pid)) FROM pg_stat_activity "
                                       "WHERE application_name = 'ilp';\n"
                                     : ""));
    EXPECT_EQ(result.exit_status, 0) << result.output;
  };
  EXPECT_GE(disturb_until_the_end(flight, 5, attack), 3);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
}

TEST_F(SpreadServer, ATableThatIsDroppedUnderTheFlightIsReportedAndTheOthersGoOn) {
  SpreadFlight flight(three);
  flight.start_all();
  for (int k = 0; k < patience_looks && flight.sql("SELECT count(*) > 5 FROM frame;\n").output.rfind('t', 0) != 0; ++k)
    sleep_ms(50);
  EXPECT_EQ(flight.sql("DROP TABLE richness;\n").exit_status, 0);
  std::string reported;
  for (int k = 0; k < patience_looks && reported.empty(); ++k) {
    sleep_ms(50);
    const std::string code = std::to_string(static_cast<int>(StatusCode::store_damaged));
    reported = flight.sql("SELECT component FROM event WHERE code = " + code + ";\n").output;
  }
  EXPECT_NE(reported, "") << flight.output(0) << flight.output(2);
  for (std::size_t process = 0; process < three.size(); ++process) EXPECT_TRUE(flight.runs(process)) << process;
  // The stages before it finish what there is.
  std::string finished;
  for (int k = 0; k < patience_looks && finished.rfind('t', 0) != 0; ++k) {
    sleep_ms(50);
    finished =
        flight.sql("SELECT max(frame.id) >= 20 AND max(frame.id) = max(overlap.id) FROM frame, overlap;\n").output;
  }
  EXPECT_EQ(finished, "t\n") << "the other stages should go on";
}

TEST_F(SpreadServer, WhenItsDiskIsFullTheFlightWaitsAndLosesNothing) {
  const test::TemporaryFolder folder;
  const test::SmallDisk disk(folder / "disk", 1);
  if (!disk.mounted()) GTEST_SKIP() << "no right to mount a small disk";
  ASSERT_EQ(
      test::run_program({"/bin/sh", "-c", "chmod 755 " + folder.path().string() + "; chown postgres " + disk.path()})
          .exit_status,
      0);
  SpreadFlight flight(three);
  ASSERT_EQ(test::run_program({ILP_STORE, "create", flight.store()}).exit_status, 0);
  const test::ProgramResult moved = flight.sql("CREATE TABLESPACE small LOCATION '" + disk.path() +
                                               "';\nALTER TABLE depth_values SET TABLESPACE small;\n");
  ASSERT_EQ(moved.exit_status, 0) << moved.output;
  flight.start_all();
  const std::string full = std::to_string(static_cast<int>(StatusCode::store_full));
  std::string reported;
  for (int k = 0; k < patience_looks && reported.empty(); ++k) {
    sleep_ms(50);
    reported = flight.sql("SELECT component FROM event WHERE code = " + full + ";\n").output;
  }
  EXPECT_NE(reported, "") << "the disk should have been too small";
  sleep_ms(500);
  ASSERT_TRUE(disk.resize(64));
  EXPECT_EQ(flight.wait(), std::vector<int>(three.size(), 0)) << flight.output(0);
  EXPECT_EQ(flight.digest(), test::digest_of_one_process());
  EXPECT_EQ(flight.sql("ALTER TABLE depth_values SET TABLESPACE pg_default;\nDROP TABLESPACE small;\n").exit_status, 0);
}

TEST_F(SpreadServer, ADatabaseOfAnotherVersionIsRefused) {
  SpreadFlight flight(three);
  ASSERT_EQ(test::run_program({ILP_STORE, "create", flight.store()}).exit_status, 0);
  ASSERT_EQ(flight.sql("UPDATE ilp_store SET fingerprint = 1;\n").exit_status, 0);
  for (const std::vector<std::string>& command : {flight.primary_command(), flight.node_command(three[1])}) {
    const test::ProgramResult result = test::run_program(command);
    EXPECT_EQ(result.exit_status, 1) << result.output;
    EXPECT_NE(result.output.find("database has schema version 1,"), std::string::npos) << result.output;
  }
}

TEST_F(SpreadServer, APasswordIsNeverAskedForOnTheCommandLine) {
  for (const std::string store :
       {"postgresql://ilp:secret@127.0.0.1/ilp", "postgresql://127.0.0.1/ilp?password=secret"}) {
    const test::ProgramResult result = test::run_program({ILP_ONBOARD, "--stages", "compressor", "--store", store});
    EXPECT_EQ(result.exit_status, 2);
    EXPECT_NE(result.output.find("PGPASSFILE"), std::string::npos) << result.output;
    EXPECT_EQ(result.output.find("secret"), std::string::npos) << result.output;
  }
}

TEST_F(SpreadServer, AWrongPasswordIsSaid) {
  const test::TemporaryFolder folder;
  test::write_file(folder / "passfile", "*:*:*:*:wrong\n");
  std::filesystem::permissions(folder / "passfile", std::filesystem::perms::owner_read);
  std::string port = std::getenv("ILP_POSTGRES_TCP");
  port = port.substr(port.find("port=") + 5);
  port = port.substr(0, port.find(' '));
  const test::ProgramResult result =
      test::run_program({"/usr/bin/env", "PGPASSFILE=" + (folder / "passfile"), ILP_ONBOARD, "--stages", "compressor",
                         "--store", "postgresql://ilp@127.0.0.1:" + port + "/ilp"});
  EXPECT_EQ(result.exit_status, 1) << result.output;
  EXPECT_NE(result.output.find("the database refuses this process"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("wrong"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace ilp
