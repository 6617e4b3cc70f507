// The stages at packet links, each alone on the inputs of a recorded flight and on what its links gave: it writes and
// sends what it wrote and sent in the flight, byte for byte. Where its process ends in between, and the ground repeats
// what was not answered, nothing is lost.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <map>
#include <memory>

#include "fsw/records/serial.hpp"
#include "hal/nonvolatile/ram_nonvolatile.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/stages/ground_station.hpp"
#include "tests/stages/recorded_flight.hpp"
#include "tests/support/queue_link.hpp"

namespace ilp::test {
namespace {

enum class Stop : std::uint8_t { never, before_writes, after_writes };

/// What lasts beyond a process is in Replay; this is the rest.
struct Process {
  Process(ComponentId stage, Store& store, Clock& clock, Nonvolatile& medium, QueueLink& packets, QueueLink& files,
          const MissionParameters& flown)
      : mission(flown), router(&packets, &files, clock, mission), writer(router, clock, mission), memory(medium) {
    EXPECT_TRUE(keys.add(station_spi, station_key).ok());
    router.authenticate_with(keys);
    const Status loaded = memory.load();
    EXPECT_TRUE(configuration.begin(store, {.loaded = loaded}).ok());
    switch (stage) {
      case ComponentId::telecommander:
        component = place<Telecommander>(store, router, writer, clock, mission, &configuration);
        break;
      case ComponentId::file_delivery:
        component = place<FileDelivery>(store, router, clock, mission, figures);
        break;
      case ComponentId::telecommand_guard:
        component = place<TelecommandGuard>(store, router, clock, &memory);
        break;
      default:
        component = place<TelemetryReporter>(store, router, writer, clock, mission);
    }
  }
  /// In memory that was zero, as static memory is.
  template <typename C, typename... Arguments>
  std::shared_ptr<C> place(Arguments&&... arguments) {
    void* const memory_of_it = std::calloc(1, sizeof(C));
    return std::shared_ptr<C>(new (memory_of_it) C(std::forward<Arguments>(arguments)...), [](C* made) {
      made->~C();
      std::free(made);
    });
  }

  MissionParameters mission;
  PacketRouter router;
  TelemetryWriter writer;
  FlightMemory memory;
  Authenticator keys;
  DeliveryFigures figures;
  Configuration configuration{memory, mission};
  std::shared_ptr<Component> component;
};

class PacketReplay {
 public:
  PacketReplay(ComponentId stage, Stop stop)
      : stage_(stage),
        stop_(stop),
        flight_(recorded_operation(stage == ComponentId::telecommand_guard ? Authentication::telecommands
                                                                           : Authentication::none)) {
    store_.before_commit = [this] {
      refused_ = cutting_;
      return cutting_ ? Status{StatusCode::io_error} : Status{};
    };
    store_.committed = [this](const Writes& writes) {
      if (process_) written_.push_back(writes);
    };
  }

  void run() {
    make();
    for (std::size_t i = 0; i < flight_.events.size(); ++i) {
      const Event& event = flight_.events[i];
      clock_.sleep_until(event.time);
      if (event.stage == place_of(stage_)) {
        if (event.kind == Event::Kind::restore) restore();
        if (event.kind == Event::Kind::step) step(i);
        if (testing::Test::HasFatalFailure()) return;
      } else {
        ASSERT_NO_FATAL_FAILURE(play(i));
      }
    }
    ASSERT_NO_FATAL_FAILURE(compare_end());
  }
  [[nodiscard]] std::size_t transactions() const { return written_.size(); }
  [[nodiscard]] std::size_t packets_sent() const { return sent_.size(); }

 private:
  /// The events between this call of a stage and the next call of any.
  [[nodiscard]] std::span<const Event> effects_of(std::size_t call) const {
    std::size_t end = call + 1;
    const auto called = [&](std::size_t i) {
      return flight_.events[i].kind == Event::Kind::step || flight_.events[i].kind == Event::Kind::restore;
    };
    while (end < flight_.events.size() && !called(end)) ++end;
    return std::span(flight_.events).subspan(call + 1, end - call - 1);
  }

  /// What another stage did.
  void play(std::size_t i) {
    const Event& event = flight_.events[i];
    switch (event.kind) {
      case Event::Kind::commit:
        ASSERT_TRUE(apply_writes(ram_, event.writes).ok());
        break;
      case Event::Kind::sent:
        // The number of a packet counts those of all stages.
        if (event.channel == Channel::commands) repeat_report(event.octets);
        break;
      case Event::Kind::step:
        if (event.stage == place_of(ComponentId::telecommander)) {
          feed(effects_of(i));
          EXPECT_TRUE(process_->router.pump().ok());
          drain(Channel::commands);
        }
        if (event.stage == place_of(ComponentId::file_delivery)) drain(Channel::files);
        break;
      default:
        break;
    }
  }
  void feed(std::span<const Event> effects) {
    for (const Event& effect : effects) {
      if (effect.kind != Event::Kind::received) continue;
      (effect.channel == Channel::files ? files_ : packets_).up.push_back(effect.octets);
      if (effect.channel == Channel::files) fresh_pdus_.push_back(effect.octets);
    }
  }
  void drain(Channel channel) {
    Octets buffer(limits::max_packet_bytes);
    std::size_t bytes = 0;
    while (process_->router.receive(channel, buffer, bytes).ok()) continue;
  }
  void repeat_report(const Octets& octets) {
    Telemetry telemetry;
    const LinkSettings& settings = process_->writer.settings();
    ASSERT_TRUE(decode_telemetry(octets, settings.apid, settings.tailoring.time, telemetry).ok());
    EXPECT_TRUE(
        process_->writer.report(telemetry.service, telemetry.subtype, telemetry.destination, telemetry.data).ok());
  }

  void step(std::size_t i) {
    const std::span<const Event> effects = effects_of(i);
    std::vector<const Writes*> expected;
    std::vector<const Event*> packets;
    for (const Event& effect : effects) {
      if (effect.stage != place_of(stage_)) continue;
      if (effect.kind == Event::Kind::commit) expected.push_back(&effect.writes);
      if (effect.kind == Event::Kind::sent) packets.push_back(&effect);
    }
    const std::size_t written = written_.size();
    packets_.down.clear();
    files_.down.clear();
    if (stage_ == ComponentId::telecommander) feed(effects);
    if (stop_ == Stop::before_writes && !expected.empty() && !only_counts(expected)) {
      cutting_ = true;
      refused_ = false;
      process_->component->step();
      cutting_ = false;
      EXPECT_TRUE(refused_);
      packets_.down.clear();
      start_again();
      if (stage_ == ComponentId::telecommander) {
        feed(effects);
      } else {
        files_.up.assign(fresh_pdus_.begin(), fresh_pdus_.end());
        EXPECT_TRUE(process_->router.pump().ok());
      }
    }
    process_->component->step();
    fresh_pdus_.clear();
    for (const Octets& octets : packets_.down) sent_.push_back(octets);
    if (stop_ == Stop::never) {
      ASSERT_NO_FATAL_FAILURE(compare_writes(expected, written));
      ASSERT_NO_FATAL_FAILURE(compare_packets(packets));
    }
    for (const Writes* writes : expected) expected_.push_back(writes);
    for (const Event* packet : packets) {
      if (packet->channel == Channel::commands) expected_packets_.push_back(packet->octets);
    }
    if (stop_ == Stop::after_writes && !expected.empty()) start_again();
  }
  void restore() { EXPECT_TRUE(restored(process_->component->restore())); }
  void start_again() {
    make();
    restore();
    // Its first step finds the transfers on record; the ground repeats what came before that.
    if (stage_ == ComponentId::file_delivery) process_->component->step();
  }

  /// Telecommands are counted every so many steps of a process, at other times after a restart.
  [[nodiscard]] bool only_counts(const std::vector<const Writes*>& expected) const {
    for (const Writes* writes : expected) {
      for (const Write& write : *writes) {
        if (write.type != RecordType::commanding && write.type != RecordType::checkpoint) return false;
      }
    }
    return stage_ == ComponentId::telecommander;
  }
  void compare_writes(const std::vector<const Writes*>& expected, std::size_t from) {
    ASSERT_EQ(written_.size() - from, expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      const Writes& is = written_[from + k];
      ASSERT_EQ(is.size(), expected[k]->size());
      for (std::size_t w = 0; w < is.size(); ++w) {
        const Write& was = (*expected[k])[w];
        ASSERT_TRUE(is[w].same(was, StateBytes::compared)) << was.name() << ", now " << is[w].name();
      }
    }
  }
  void compare_packets(const std::vector<const Event*>& expected) {
    std::size_t packets = 0, pdus = 0;
    for (const Event* packet : expected) {
      const bool file = packet->channel == Channel::files;
      const std::vector<Octets>& down = file ? files_.down : packets_.down;
      std::size_t& place = file ? pdus : packets;
      ASSERT_LT(place, down.size());
      ASSERT_EQ(down[place++], packet->octets);
    }
    ASSERT_EQ(packets, packets_.down.size());
    ASSERT_EQ(pdus, files_.down.size());
  }

  /// All contents of the records by table and id in the order of their writes, without what counts steps, attempts or
  /// the life of a process. An erased record ends with no octets.
  using Histories = std::map<std::pair<RecordType, std::int64_t>, std::vector<Octets>>;
  static void take(const Writes& writes, Histories& histories) {
    for (const Write& write : writes) {
      if (write.type == RecordType::checkpoint || write.type == RecordType::commanding) continue;
      if (write.kind == Write::Kind::blob) continue;
      Octets bytes = write.kind == Write::Kind::put ? write.bytes : Octets{};
      if (write.kind == Write::Kind::put && write.type == RecordType::transfer) {
        TransferRecord record;
        std::memcpy(&record, write.record.data(), sizeof(record));
        record.resent_bytes = 0;
        EXPECT_TRUE(serialize(record_info<TransferRecord>(), &record, bytes).ok());
      }
      std::vector<Octets>& history = histories[{write.type, write.id}];
      if (history.empty() || history.back() != bytes) history.push_back(bytes);
    }
  }
  /// All of the second history in its order, to the same end.
  static bool passes_through(const std::vector<Octets>& is, const std::vector<Octets>& was) {
    auto place = is.begin();
    for (const Octets& bytes : was) {
      place = std::find(place, is.end(), bytes);
      if (place == is.end()) return false;
    }
    return is.back() == was.back();
  }
  /// Service, subtype, destination and content of reports that tell what became of something: all but periodic ones.
  [[nodiscard]] std::vector<Octets> contents(const std::vector<Octets>& packets) const {
    std::vector<Octets> reports;
    for (const Octets& octets : packets) {
      Telemetry telemetry;
      const LinkSettings& settings = process_->writer.settings();
      EXPECT_TRUE(decode_telemetry(octets, settings.apid, settings.tailoring.time, telemetry).ok());
      if (telemetry.service == 3) continue;
      Octets content = {telemetry.service, telemetry.subtype, static_cast<std::uint8_t>(telemetry.destination)};
      content.insert(content.end(), telemetry.data.begin(), telemetry.data.end());
      reports.push_back(content);
    }
    return reports;
  }
  void compare_end() {
    Histories is, was;
    for (const Writes& writes : written_) take(writes, is);
    for (const Writes* writes : expected_) take(*writes, was);
    EXPECT_EQ(is.size(), was.size());
    for (const auto& [key, history] : was) {
      // A transfer goes on from what is on record, which is another place of the file than in the flight.
      const bool same = key.first == RecordType::transfer ? passes_through(is[key], history) : is[key] == history;
      EXPECT_TRUE(same) << record_info(key.first).name << " " << key.second;
    }
    Cursor cursor, flown;
    EXPECT_TRUE(saved_cursor(ram_, stage_, cursor).ok());
    for (const Writes* writes : expected_) {
      for (const Write& write : *writes) {
        if (write.type != RecordType::checkpoint || write.kind != Write::Kind::put) continue;
        CheckpointRecord record;
        std::memcpy(&record, write.record.data(), sizeof(record));
        flown = {record.cursor, record.cursor_second};
      }
    }
    EXPECT_EQ(cursor.first, flown.first);
    EXPECT_EQ(cursor.second, flown.second);
    const std::vector<Octets> sent = contents(sent_);
    for (const Octets& report : contents(expected_packets_)) {
      EXPECT_NE(std::find(sent.begin(), sent.end(), report), sent.end())
          << "report [" << int{report[0]} << "," << int{report[1]} << "] was not sent";
    }
    const std::vector<Octets> reports = contents(expected_packets_);
    for (const Octets& report : sent) {
      EXPECT_NE(std::find(reports.begin(), reports.end(), report), reports.end())
          << "report [" << int{report[0]} << "," << int{report[1]} << "] was not sent in the flight";
    }
    if (stage_ == ComponentId::telecommand_guard) compare_marks();
  }
  void compare_marks() {
    // Its checkpoint is all that the guard writes.
    const SequenceMarks marks = process_->router.authenticator()->marks();
    start_again();
    const SequenceMarks after = process_->router.authenticator()->marks();
    ASSERT_EQ(marks.size(), 1U);
    ASSERT_EQ(after.size(), 1U);
    EXPECT_EQ(after[0].highest, marks[0].highest);
    EXPECT_GT(marks[0].highest, 5U);
  }

  void make() {
    process_.reset();
    packets_.up.clear();
    files_.up.clear();
    process_ = std::make_unique<Process>(stage_, store_, clock_, medium_, packets_, files_, flight_.mission);
  }

  ComponentId stage_;
  Stop stop_;
  const Recording& flight_;
  std::vector<std::byte> region_ = std::vector<std::byte>(std::size_t{48} << 20U);
  RamStore ram_{region_};
  RecordingStore store_{ram_};
  StillClock clock_;
  RamNonvolatile medium_;
  QueueLink packets_, files_;
  std::unique_ptr<Process> process_;
  std::vector<Octets> fresh_pdus_;  ///< that have come since the stage's last step
  bool cutting_ = false, refused_ = false;
  std::vector<Writes> written_;
  std::vector<const Writes*> expected_;
  std::vector<Octets> sent_, expected_packets_;
};

class PacketStageReplay : public testing::TestWithParam<ComponentId> {
 protected:
  void replay(Stop stop) const {
    PacketReplay replay(GetParam(), stop);
    replay.run();
    EXPECT_GT(replay.transactions(), 2U) << "the flight gives it nothing to do";
    const bool reports = GetParam() == ComponentId::telecommander || GetParam() == ComponentId::telemetry;
    EXPECT_TRUE(!reports || replay.packets_sent() > 3);
  }
};

TEST_P(PacketStageReplay, AloneItWritesAndSendsTheSameBytes) {
  replay(Stop::never);
}

TEST_P(PacketStageReplay, AStopBeforeEachWriteLosesNothing) {
  replay(Stop::before_writes);
}

TEST_P(PacketStageReplay, AStopAfterEachWriteLosesNothing) {
  replay(Stop::after_writes);
}

INSTANTIATE_TEST_SUITE_P(Stages, PacketStageReplay,
                         testing::Values(ComponentId::telecommander, ComponentId::file_delivery,
                                         ComponentId::telecommand_guard, ComponentId::telemetry),
                         [](const auto& about) { return std::string(stage_of(about.param).name); });

}  // namespace
}  // namespace ilp::test
