// Whatever was commanded and whatever was lost: the ground gets back in (docs/getting-back-in.md).
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <set>

#include "fsw/packets/service_schedule.hpp"
#include "hal/store/sqlite/checked_vfs.hpp"
#include "tests/integration/flight_board.hpp"
#include "tests/support/store_records.hpp"
#include "tests/unit/hal/expect_status.hpp"

namespace ilp {
namespace {

namespace fs = std::filesystem;
using test::FlightBoard;
using test::Octets;

const char* const done = "1.1 1.3 1.7";
const char* const refused = "1.1 1.4";

class GettingBackIn : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(board_->start().ok()); }
  /// The reasons in the events configuration_reverted, in order.
  std::vector<int> reasons() {
    std::vector<int> list;
    for (const EventRecord& event : board_->events(StatusCode::configuration_reverted)) {
      list.push_back(static_cast<int>(event.a));
    }
    return list;
  }
  /// The first value that `sql` gives as a number, or 0.
  static int on_database(const std::string& path, const std::string& sql) {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READWRITE, checked_vfs), SQLITE_OK);
    int value = 0;
    const auto take = [](void* to, int, char** values, char**) {
      *static_cast<int*>(to) = std::stoi(values[0]);
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), take, &value, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    EXPECT_EQ(sqlite3_close(database), SQLITE_OK);
    return value;
  }
  static std::vector<std::string> tables_with_rows(const std::string& path) {
    std::vector<std::string> filled;
    for (std::size_t type = 0; type < static_cast<std::size_t>(RecordType::count); ++type) {
      const std::string table = record_info(static_cast<RecordType>(type)).name;
      if (on_database(path, "SELECT count(*) FROM \"" + table + "\"") > 0) filled.push_back(table);
    }
    return filled;
  }
  /// Sets it as a telecommand would, without the refusals.
  void force(const char* section, const char* key, double value) {
    board_->stop();
    FileNonvolatile medium;
    ASSERT_TRUE(medium.open(board_->database().c_str()).ok());
    FlightMemory memory(medium);
    ASSERT_TRUE(memory.load().ok());
    FlightMemoryContent content = memory.content();
    ASSERT_TRUE(content.wanted.set(parameter_info(find_parameter(section, key)).number, value));
    ++content.configuration;
    ASSERT_TRUE(memory.keep(content).ok());
  }

  static void copy_small_memory(const std::string& from, const std::string& to) {
    for (const char* const file : {".keep-1", ".keep-2"}) {
      fs::copy_file(from + file, to + file, fs::copy_options::overwrite_existing);
    }
  }

  std::unique_ptr<FlightBoard> board_ = std::make_unique<FlightBoard>();
};

// Defect 5, four cases.

TEST_F(GettingBackIn, AnotherCameraKnownByTelecommandDoesNotKeepTheFlightFromStarting) {
  ASSERT_EQ(board_->set("calibration", "camera_known", 0), done);
  ASSERT_OK(board_->restart());
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->in_force("calibration", "camera_known"), 1);
  EXPECT_EQ(reasons(), (std::vector<int>{1}));
  ASSERT_OK(board_->restart());
  EXPECT_EQ(reasons(), (std::vector<int>{1})) << "abandoned for good";
}

TEST_F(GettingBackIn, AMissionEpochInTheFutureIsRefusedAndDoesNotKeepTheFlightFromStarting) {
  EXPECT_EQ(board_->set("link", "mission_epoch_s", 3e9), refused);
  EXPECT_TRUE(board_->ping());
  force("link", "mission_epoch_s", 3e9);
  ASSERT_OK(board_->start());
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->events(StatusCode::clock_behind).size(), 1U);
}

TEST_F(GettingBackIn, AMissionEpochInTheFutureThatNobodyConfirmsIsGivenUp) {
  board_->fly(5);
  const double epoch_s = board_->in_force("link", "mission_epoch_s");
  const TimeNs before = board_->clock.now();
  force("link", "mission_epoch_s", 3e9);
  ASSERT_OK(board_->start());
  EXPECT_GE(board_->clock.now(), before - 5 * ns_per_s) << "mission time does not go back";
  board_->fly_on(70);
  EXPECT_EQ(board_->restarts, 1);
  EXPECT_EQ(board_->in_force("link", "mission_epoch_s"), epoch_s);
  EXPECT_EQ(reasons(), (std::vector<int>{2}));
  EXPECT_TRUE(board_->ping());
}

TEST_F(GettingBackIn, TheEpochOfTheMissionFileIsOnTrialWhereTheFlightHasAnother) {
  const double epoch_s = board_->in_force("link", "mission_epoch_s");
  ASSERT_NE(epoch_s, board_->mission_file.mission_epoch_s);
  ASSERT_EQ(board_->set("link", "mission_epoch_s", board_->mission_file.mission_epoch_s), done);
  ASSERT_OK(board_->restart());
  EXPECT_EQ(board_->in_force("link", "mission_epoch_s"), board_->mission_file.mission_epoch_s);
  board_->fly_on(70);
  EXPECT_EQ(board_->in_force("link", "mission_epoch_s"), epoch_s);
  EXPECT_EQ(reasons(), (std::vector<int>{2}));
  ASSERT_EQ(board_->set("link", "mission_epoch_s", board_->mission_file.mission_epoch_s), done);
  ASSERT_OK(board_->restart());
  ASSERT_TRUE(board_->ping());
  board_->fly_on(70);
  EXPECT_EQ(board_->in_force("link", "mission_epoch_s"), board_->mission_file.mission_epoch_s) << "confirmed";
}

TEST_F(GettingBackIn, PassesWithoutAFutureContactAreGivenUp) {
  Octets octets(64);
  ByteWriter out(octets);
  out.u16(2);
  for (const auto& [key, value] : {std::pair{"pass_period_s", 1000.0}, std::pair{"pass_start_s", 1e9}}) {
    const std::size_t index = find_parameter("downlink", key);
    out.u16(parameter_info(index).number);
    write_value(parameter_info(index).type, value, out);
  }
  octets.resize(out.size());
  board_->send(board_->packet(20, 3, octets));
  // The report of its completion waits: there is no contact any more.
  EXPECT_FALSE(board_->ping());
  board_->fly(50);
  EXPECT_FALSE(board_->ping()) << "no contact";
  board_->fly(10);
  EXPECT_EQ(board_->in_force("downlink", "pass_start_s"), 0);
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(reasons(), (std::vector<int>{2}));
  EXPECT_EQ(board_->restarts, 0) << "it acts at once, and needs no start";
  ASSERT_OK(board_->restart());
  EXPECT_TRUE(board_->ping());
}

TEST_F(GettingBackIn, AnAgencysEpochInTheFutureIsRefusedAndSilencesNobody) {
  ASSERT_EQ(board_->set("link", "cuc_time", 1), done);
  EXPECT_EQ(board_->set("link", "agency_epoch_s", 3.9e9), refused);
  force("link", "agency_epoch_s", 3.9e9);
  ASSERT_OK(board_->start());
  board_->send(board_->ping_packet());
  EXPECT_EQ(board_->answers(), "1.1 1.3 17.2 1.7") << "with the time that can be told";
}

TEST_F(GettingBackIn, TheMissionFileMaySayWhatTelecommandsMayNot) {
  board_->stop();
  fs::remove_all(board_->folder / "");
  FlightBoard another;
  another.epoch_choice = EpochChoice::mission;
  another.mission_file.mission_epoch_s = 3e9;
  another.mission_file.agency_epoch_s = 3.9e9;
  another.mission_file.cuc_time = 1;
  ASSERT_OK(another.start());
  EXPECT_TRUE(another.ping());
}

// What is tentative.

TEST_F(GettingBackIn, ATelecommandBehindItsEffectConfirmsAConfiguration) {
  ASSERT_EQ(board_->set("link", "telecommands_per_s", 10), done);
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->events(StatusCode::configuration_confirmed).size(), 1U);
  board_->fly(200);
  EXPECT_EQ(board_->in_force("link", "telecommands_per_s"), 10);
  EXPECT_TRUE(reasons().empty());
}

TEST_F(GettingBackIn, WhatActsWithAStartIsConfirmedBehindIt) {
  ASSERT_EQ(board_->set("link", "apid", 300), done);
  EXPECT_TRUE(board_->ping());
  EXPECT_TRUE(board_->events(StatusCode::configuration_confirmed).empty()) << "it has not acted yet";
  board_->fly(200);
  EXPECT_TRUE(reasons().empty()) << "contact is what it was";
  ASSERT_OK(board_->restart());
  EXPECT_EQ(board_->in_force("link", "apid"), 300);
  // The ground does not know of it.
  board_->fly_on(100);
  EXPECT_EQ(board_->in_force("link", "apid"), 239);
  EXPECT_EQ(reasons(), (std::vector<int>{2}));
  EXPECT_TRUE(board_->ping());
  ASSERT_EQ(board_->set("link", "apid", 300), done);
  ASSERT_OK(board_->restart());
  board_->apid = 300;
  EXPECT_TRUE(board_->ping());
  board_->fly_on(100);
  EXPECT_TRUE(board_->ping()) << "confirmed";
}

TEST_F(GettingBackIn, WhatHadBeenSentBeforeConfirmsNothing) {
  board_->send(board_->setting("downlink", "pass_start_s", 1e9));
  board_->send(board_->setting("downlink", "pass_period_s", 1000));
  for (int i = 0; i < 5; ++i) board_->send(board_->ping_packet());
  board_->fly(62);
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->in_force("downlink", "pass_period_s"), 0);
}

TEST_F(GettingBackIn, ARequestOfTheScheduleConfirmsNothing) {
  Octets octets(200);
  ByteWriter out(octets);
  const Tailoring tailoring = tailoring_of(GroundSystem::standard, false, 0);
  encode_insert_head(tailoring, 0, 1, out);
  const Octets inner = board_->ping_packet();
  ScheduleItem item;
  item.release = MissionTime(board_->in_force("link", "mission_epoch_s")).utc(board_->clock.now() + 5 * ns_per_s);
  item.packet = inner;
  ASSERT_OK(encode_insert_item(tailoring, item, out));
  octets.resize(out.size());
  board_->send(board_->packet(scheduling::service, scheduling::insert, octets));
  EXPECT_EQ(board_->answers(0.3), done);
  board_->send(board_->setting("link", "telecommands_per_s", 1));
  EXPECT_EQ(board_->answers(10), "1.1 1.3 1.7 1.1 1.3 17.2 1.7") << "it was released";
  board_->fly(60);
  EXPECT_EQ(board_->in_force("link", "telecommands_per_s"), 200);
}

TEST_F(GettingBackIn, ATrialGoesOnThroughRestartsAndWhoCannotBeAnsweredConfirmsNothing) {
  board_->mission_file.trial_s = 200;
  ASSERT_OK(board_->restart());
  ASSERT_TRUE(board_->ping());
  board_->send(board_->setting("downlink", "link_bytes_per_s", 0));
  board_->fly(130);
  EXPECT_FALSE(board_->ping()) << "it is accepted, but nothing goes down";
  ASSERT_OK(board_->restart());
  EXPECT_FALSE(board_->ping());
  EXPECT_EQ(board_->in_force("downlink", "link_bytes_per_s"), 0);
  board_->fly(90);
  EXPECT_EQ(board_->in_force("downlink", "link_bytes_per_s"), 200000);
  EXPECT_TRUE(board_->ping());
}

TEST_F(GettingBackIn, ASettingOfAnUnknownNumberIsKeptAndToldOnce) {
  board_->stop();
  {
    FileNonvolatile medium;
    ASSERT_TRUE(medium.open(board_->database().c_str()).ok());
    FlightMemory memory(medium);
    ASSERT_TRUE(memory.load().ok());
    FlightMemoryContent content = memory.content();
    for (KeptSettings* const settings : {&content.good, &content.wanted}) {
      ASSERT_TRUE(settings->set(60000, 1));
      ASSERT_TRUE(settings->set(60001, 2));
      ASSERT_TRUE(settings->set(parameter_info(find_parameter("motion", "corners")).number, 500));
    }
    ASSERT_TRUE(memory.keep(content).ok());
  }
  ASSERT_OK(board_->start());
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  ASSERT_EQ(board_->events(StatusCode::setting_ignored).size(), 1U);
  EXPECT_EQ(board_->events(StatusCode::setting_ignored)[0].a, 60000);
  EXPECT_EQ(board_->memory().content().wanted.find(60001)->value, 2) << "a software that knows it takes it up again";
}

TEST_F(GettingBackIn, ParametersThatDoNotConcernContactNeedNoTrial) {
  ASSERT_EQ(board_->set("motion", "corners", 500), done);
  board_->fly(300);
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  ASSERT_OK(board_->restart());
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  EXPECT_TRUE(reasons().empty());
}

TEST_F(GettingBackIn, APassThatIsCommandedIsNotGivenUp) {
  board_->send(board_->packet(8, 1, {'P', 'A', 'S', 'S', 'B', 'E', 'G', 0, 0, 0, 0x10, 0}));
  EXPECT_EQ(board_->answers(0.3), done);
  board_->fly(300);
  EXPECT_TRUE(reasons().empty());
}

// The ladder of starts.

TEST_F(GettingBackIn, RepeatedStartsStepDownAndATelecommandStepsUp) {
  ASSERT_EQ(board_->set("motion", "corners", 500), done);
  ASSERT_EQ(board_->set("link", "telecommands_per_s", 50), done);
  ASSERT_TRUE(board_->ping());
  ASSERT_EQ(board_->set("link", "telecommands_per_s", 7), done);
  const auto rate = [&] { return board_->in_force("link", "telecommands_per_s"); };
  // The present start was confirmed.
  for (int start = 1; start <= 2; ++start) {
    ASSERT_OK(board_->restart());
    EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::as_set) << start;
    EXPECT_EQ(rate(), 7) << start;
    board_->fly(5);
  }
  ASSERT_OK(board_->restart());
  EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::last_good);
  EXPECT_EQ(rate(), 50);
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  board_->fly(5);
  EXPECT_EQ(reasons(), (std::vector<int>{3}));
  for (int start = 4; start <= 6; ++start) {
    ASSERT_OK(board_->restart());
    EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::built_in) << start;
    EXPECT_EQ(rate(), 200);
    EXPECT_EQ(board_->in_force("motion", "corners"), 1000);
    board_->fly(5);
  }
  EXPECT_EQ(board_->events(StatusCode::defaults_in_force).size(), 3U);
  EXPECT_TRUE(board_->ping());
  ASSERT_OK(board_->restart());
  EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::as_set);
  EXPECT_EQ(rate(), 50);
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  EXPECT_TRUE(board_->ping());
}

TEST_F(GettingBackIn, TelecommandsThatCannotBeAnsweredDoNotStopTheSteps) {
  board_->send(board_->setting("downlink", "link_bytes_per_s", 0));
  board_->fly(2);
  // Shorter than what is kept of a trial, and the ground goes on to command.
  for (int start = 1; start <= 2; ++start) {
    ASSERT_OK(board_->restart());
    EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::as_set) << start;
    for (int i = 0; i < 5; ++i) EXPECT_FALSE(board_->ping());
  }
  ASSERT_OK(board_->restart());
  EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::last_good);
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(reasons(), (std::vector<int>{3}));
}

TEST_F(GettingBackIn, BuiltInDefaultsListenWhateverTheMissionFileSays) {
  board_->mission_file.pass_period_s = 1000;
  board_->mission_file.pass_start_s = 1e9;
  board_->mission_file.link_bytes_per_s = 0;
  board_->mission_file.apid = 77;
  board_->mission_file.storage_budget_mib = 500;
  for (int start = 0; start < 4; ++start) {
    ASSERT_OK(board_->restart());
    board_->fly(3);
  }
  EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::built_in);
  EXPECT_EQ(board_->in_force("storage", "storage_budget_mib"), 500) << "what is stored stays stored";
  board_->apid = 77;
  EXPECT_TRUE(board_->ping());
}

TEST_F(GettingBackIn, BuiltInDefaultsDemandTheKeysThatTheGroundUsesLast) {
  board_->key_list = {{5, Octets(32, 9)}};
  ASSERT_OK(board_->restart());
  ASSERT_EQ(board_->set("link", "authentication", 1), done);
  board_->send(board_->sealed(board_->ping_packet(), 1));
  EXPECT_EQ(board_->answers(), "1.1 1.3 17.2 1.7");
  for (int start = 0; start < 4; ++start) {
    ASSERT_OK(board_->restart());
    board_->fly(3);
  }
  EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::built_in);
  EXPECT_FALSE(board_->ping());
  board_->send(board_->sealed(board_->ping_packet(), 2));
  EXPECT_EQ(board_->answers(), "1.1 1.3 17.2 1.7");
}

TEST_F(GettingBackIn, AStartThatLastsOrAnOrderedEndIsInNoCircle) {
  for (int start = 0; start < 6; ++start) {
    ASSERT_OK(board_->restart());
    board_->fly(61);
    EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::as_set) << start;
  }
  for (int start = 0; start < 6; ++start) {
    ASSERT_OK(board_->restart());
    board_->fly(1);
    board_->configuration().end_in_order(board_->clock.now());
    EXPECT_EQ(board_->configuration().stage(), ConfigurationStage::as_set) << start;
  }
}

// What outlives the database.

TEST_F(GettingBackIn, AuthenticationAndMarksOutliveTheDatabase) {
  board_->key_list = {{5, Octets(32, 9)}};
  ASSERT_OK(board_->restart());
  ASSERT_EQ(board_->set("link", "authentication", 1), done);
  const Octets recorded = board_->sealed(board_->ping_packet(), 10);
  board_->send(recorded);
  EXPECT_EQ(board_->answers(), "1.1 1.3 17.2 1.7");
  board_->stop();
  std::ofstream(board_->database(), std::ios::trunc) << std::string(20000, 'x');
  fs::remove(board_->database() + "-wal");
  ASSERT_OK(board_->start());
  EXPECT_STATUS(board_->store->updates(), store_set_aside);
  EXPECT_EQ(board_->in_force("link", "authentication"), 1);
  board_->send(recorded);
  EXPECT_EQ(board_->answers(), "") << "a recorded telecommand";
  EXPECT_FALSE(board_->ping()) << "without a key";
  board_->send(board_->sealed(board_->ping_packet(), 11));
  EXPECT_EQ(board_->answers(), "1.1 1.3 17.2 1.7");
}

TEST_F(GettingBackIn, MissionTimeAndItsEpochOutliveTheDatabase) {
  board_->fly(130);
  const double epoch_s = board_->in_force("link", "mission_epoch_s");
  const TimeNs before = board_->clock.now();
  board_->stop();
  fs::remove(board_->database());
  board_->calendar_s += 30;
  ASSERT_OK(board_->start());
  EXPECT_EQ(board_->in_force("link", "mission_epoch_s"), epoch_s);
  EXPECT_GE(board_->clock.now(), before);
  board_->stop();
  fs::remove(board_->database());
  board_->calendar_s -= 5000;
  ASSERT_OK(board_->start());
  EXPECT_GE(board_->clock.now(), before - 60 * ns_per_s) << "as it was last kept, in spite of the clock";
  EXPECT_TRUE(board_->ping());
}

TEST_F(GettingBackIn, WhateverTableIsDamagedFromEndToEndTheStartSucceedsAndThePingIsAnswered) {
  ASSERT_EQ(board_->set("motion", "corners", 500), done);
  ASSERT_OK(board_->restart());
  ASSERT_TRUE(board_->ping());
  board_->stop();
  const std::vector<std::string> tables = tables_with_rows(board_->database());
  for (const char* const table : {"camera", "checkpoint", "event", "identity", "setting", "start"}) {
    EXPECT_NE(std::find(tables.begin(), tables.end(), table), tables.end()) << table;
  }
  for (const std::string& table : tables) {
    SCOPED_TRACE(table);
    on_database(board_->database(), "UPDATE \"" + table + "\" SET record_checksum = record_checksum + 1");
    ASSERT_OK(board_->start());
    EXPECT_TRUE(board_->ping());
    EXPECT_EQ(board_->in_force("motion", "corners"), 500);
    ASSERT_OK(board_->restart());
    EXPECT_TRUE(board_->ping());
    board_->stop();
  }
}

TEST_F(GettingBackIn, SettingsComeBackFromTheDatabaseWhereTheSmallMemoryIsLost) {
  ASSERT_EQ(board_->set("motion", "corners", 500), done);
  ASSERT_EQ(board_->set("link", "apid", 300), done);
  ASSERT_OK(board_->restart());
  board_->apid = 300;
  ASSERT_TRUE(board_->ping());
  board_->stop();
  for (const char* const file : {".keep-1", ".keep-2"}) {
    std::ofstream(board_->database() + file, std::ios::trunc) << std::string(16384, 'y');
  }
  ASSERT_OK(board_->start());
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  EXPECT_EQ(board_->events(StatusCode::memory_lost).size(), 1U);
  board_->stop();
  for (const char* const file : {".keep-1", ".keep-2"}) fs::remove(board_->database() + file);
  ASSERT_OK(board_->start());
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
}

TEST_F(GettingBackIn, ASettingThatWasCutOffBeforeTheSmallMemoryIsOnTrial) {
  ASSERT_EQ(board_->set("motion", "corners", 500), done);
  board_->stop();
  std::set<std::string> kept;
  copy_small_memory(board_->database(), board_->folder / "before");
  ASSERT_OK(board_->start());
  ASSERT_EQ(board_->set("link", "apid", 300), done);
  board_->stop();
  copy_small_memory(board_->folder / "before", board_->database());
  ASSERT_OK(board_->start());
  EXPECT_EQ(board_->in_force("link", "apid"), 300) << "the telecommand was answered as done";
  board_->fly_on(100);
  EXPECT_EQ(board_->in_force("link", "apid"), 239);
  EXPECT_EQ(board_->in_force("motion", "corners"), 500);
}

TEST_F(GettingBackIn, TheFirstSettingOfAFlightThatWasCutOffBeforeTheSmallMemoryIsOnTrialToo) {
  board_->stop();
  copy_small_memory(board_->database(), board_->folder / "before");
  ASSERT_OK(board_->start());
  ASSERT_EQ(board_->set("contact", "closed_until_s", 1e9), done);
  board_->stop();
  copy_small_memory(board_->folder / "before", board_->database());
  ASSERT_OK(board_->start());
  EXPECT_FALSE(board_->ping()) << "no contact";
  board_->fly_on(100);
  EXPECT_TRUE(board_->ping());
  EXPECT_EQ(reasons(), (std::vector<int>{2}));
}

TEST_F(GettingBackIn, AFlippedBitInTheConfigurationIsMendedBeforeItActs) {
  ASSERT_EQ(board_->set("link", "telecommands_per_s", 50), done);
  auto& wanted = const_cast<MissionParameters&>(board_->configuration().wanted());
  wanted.telecommands_per_s = 1;
  wanted.pass_start_s = 1e9;
  board_->fly(0.2);
  EXPECT_EQ(board_->configuration().wanted().telecommands_per_s, 50);
  EXPECT_EQ(board_->configuration().wanted().pass_start_s, 0);
  EXPECT_TRUE(board_->ping());
}

// Clocks at their ends.

TEST_F(GettingBackIn, UptimesAndCalendarsThatJumpForwardsLeaveTheFlightInReach) {
  constexpr TimeNs two_to_31 = std::int64_t{1} << 31U, two_to_32 = std::int64_t{1} << 32U;
  // Counts of milliseconds, of minor frames and of seconds in 31 and 32 bits, 10^9 s, and the latest mission time.
  for (const TimeNs end :
       {two_to_31 * ns_per_ms, two_to_32 * ns_per_ms, two_to_31 * minor_frame_ns, two_to_32 * minor_frame_ns,
        1'000'000'000 * ns_per_s, two_to_31 * ns_per_s, longest_duration_ns - 100 * ns_per_s}) {
    SCOPED_TRACE(end / ns_per_s);
    board_->jump_to(end - 3 * ns_per_s);
    EXPECT_TRUE(board_->ping());
    board_->fly(2);
    EXPECT_TRUE(board_->ping()) << "in flight";
    EXPECT_EQ(board_->set("motion", "corners", 500), done);
    ASSERT_OK(board_->restart());
    EXPECT_TRUE(board_->ping()) << "at the next start";
    EXPECT_GE(board_->clock.now(), end - 5 * ns_per_s);
    board_->fly(62);
    board_->stop();
    board_->calendar_s = 378'691'200;
    ASSERT_OK(board_->start());
    EXPECT_GE(board_->clock.now(), end - 5 * ns_per_s) << "a calendar of 1970 does not take it back";
    EXPECT_TRUE(board_->ping());
    EXPECT_EQ(board_->in_force("motion", "corners"), 500);
  }
  EXPECT_TRUE(board_->events(StatusCode::memory_lost).empty());
  EXPECT_TRUE(reasons().empty());
}

TEST_F(GettingBackIn, ACalendarThatNoFlightCanHaveCostsNothingThatIsKept) {
  ASSERT_EQ(board_->set("link", "telecommands_per_s", 50), done);
  ASSERT_TRUE(board_->ping());
  board_->fly(70);
  // 2232 is the latest year that Linux can be set to.
  const std::int64_t right_s = board_->calendar_now();
  for (const std::int64_t wrong_s : {std::int64_t{2'145'916'800} + 206 * std::int64_t{31'556'952}, std::int64_t{0}}) {
    board_->stop();
    board_->calendar_s = wrong_s;
    ASSERT_OK(board_->start());
    EXPECT_TRUE(board_->ping()) << wrong_s;
    board_->fly(70);
    EXPECT_LT(board_->clock.now(), 3600 * ns_per_s);
    board_->stop();
    board_->calendar_s = right_s + 600;
    ASSERT_OK(board_->start());
    EXPECT_TRUE(board_->ping());
    EXPECT_EQ(board_->in_force("link", "telecommands_per_s"), 50);
  }
  EXPECT_TRUE(board_->events(StatusCode::memory_lost).empty());
}

// Numbers over store epochs.

TEST_F(GettingBackIn, InTheLastStoreEpochsNumbersBeyondThirtyTwoBitsAreToldAndNamed) {
  for (const std::int64_t store_epoch : {44, 50, 51, 52}) {
    SCOPED_TRACE(store_epoch);
    board_->stop();
    {
      FileNonvolatile medium;
      ASSERT_TRUE(medium.open(board_->database().c_str()).ok());
      FlightMemory memory(medium);
      ASSERT_TRUE(memory.load().ok());
      FlightMemoryContent content = memory.content();
      content.life = std::max(content.life, store_epoch - 1);
      ASSERT_TRUE(memory.keep(content).ok());
    }
    fs::remove(board_->database());
    ASSERT_OK(board_->start());
    EXPECT_TRUE(board_->ping());
    EXPECT_EQ(board_->set("motion", "corners", 500), done);
    board_->fly(150);
    IdentityRecord identity;
    ASSERT_OK(get(board_->store->store(), 1, identity));
    EXPECT_EQ(identity.life, store_epoch);
    EXPECT_GT(identity.keyframe_base, std::int64_t{1} << 32U);
    const std::vector<EventRecord> begun = board_->events(StatusCode::life_begun);
    ASSERT_EQ(begun.size(), 1U);
    EXPECT_GT(begun[0].id, identity.record_base);
    EXPECT_EQ(begun[0].a, store_epoch);
    // A file of events has a number of this store epoch in its name.
    TransferRecord transfer;
    ASSERT_OK(last(board_->store->store(), transfer));
    EXPECT_GT(transfer.id, identity.record_base);
    EXPECT_NE(std::string(transfer.name).find(".ilp"), std::string::npos) << transfer.name;
    ASSERT_OK(board_->restart());
    EXPECT_TRUE(board_->ping());
  }
}

TEST_F(GettingBackIn, EveryDatabaseIsAnotherStoreEpochWithNumbersOfItsOwn) {
  std::set<std::int64_t> events, starts, transactions;
  std::map<std::uint64_t, int> store_epoch_of_transaction;
  for (int store_epoch = 1; store_epoch <= 4; ++store_epoch) {
    EXPECT_TRUE(board_->ping());
    board_->fly(90);
    Store& store = board_->store->store();
    IdentityRecord identity;
    ASSERT_OK(get(store, 1, identity));
    EXPECT_EQ(identity.life, store_epoch);
    EXPECT_EQ(identity.keyframe_base, (store_epoch - 1) * 100'000'000);
    for (const EventRecord& event : test::records_of<EventRecord>(store)) {
      EXPECT_TRUE(events.insert(event.id).second) << event.id;
    }
    for (const StartRecord& start : test::records_of<StartRecord>(store)) {
      EXPECT_TRUE(starts.insert(start.id).second) << start.id;
    }
    // Files of events go down by CFDP: sequence numbers of their PDUs.
    for (const Octets& octets : board_->link.down) {
      if (octets.size() < 20 || ((octets[0] & 7U) << 8U | octets[1]) != cfdp_apid) continue;
      const std::span<const std::uint8_t> pdu = std::span<const std::uint8_t>(octets).subspan(6);
      const std::size_t entity = ((pdu[3] >> 4U) & 7U) + 1, width = (pdu[3] & 7U) + 1;
      ByteReader number(pdu.subspan(4 + entity, width));
      const int known = store_epoch_of_transaction.emplace(number.number(width), store_epoch).first->second;
      EXPECT_EQ(known, store_epoch) << "a transaction number of another store epoch";
    }
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(transactions.insert(board_->memory().next_transaction(0)).second);
    board_->stop();
    fs::remove(board_->database());
    ASSERT_OK(board_->start());
  }
  EXPECT_EQ(*starts.begin(), 1);
  EXPECT_GE(store_epoch_of_transaction.size(), 3U) << "hardly a file went";
}

TEST_F(GettingBackIn, WhereNothingIsKeptNumbersBeginByTheCalendar) {
  std::int64_t base = 0;
  for (int store_epoch = 1; store_epoch <= 3; ++store_epoch) {
    board_->stop();
    fs::remove(board_->database());
    std::ofstream(board_->database(), std::ios::trunc) << std::string(20000, 'x');
    for (const char* const file : {".keep-1", ".keep-2"}) {
      fs::remove(board_->database() + file);
      fs::create_directory(board_->database() + file);
    }
    board_->calendar_s += 60;
    ASSERT_OK(board_->start());
    EXPECT_TRUE(board_->ping());
    IdentityRecord identity;
    ASSERT_OK(get(board_->store->store(), 1, identity));
    EXPECT_GE(identity.keyframe_base, base + 60);
    EXPECT_LT(identity.keyframe_base, 10'000'000'000) << "names of files have room for ten digits";
    EXPECT_GT(identity.keyframe_base, 50 * std::int64_t{100'000'000}) << "behind every store epoch that is counted";
    base = identity.keyframe_base;
    EXPECT_EQ(board_->events(StatusCode::memory_lost).size(), 1U);
  }
}

}  // namespace
}  // namespace ilp
