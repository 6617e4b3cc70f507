// The Telecommander with a ground station at the other end of a link in memory.
#pragma once

#include <memory>
#include <string>

#include "fsw/commanding/telecommander.hpp"
#include "fsw/packets/service_parameters.hpp"
#include "tests/support/failing_store.hpp"
#include "tests/support/queue_link.hpp"
#include "tests/unit/shared/component_fixture.hpp"

namespace ilp::test {

using Bytes = std::vector<std::uint8_t>;

/// A report as the ground reads it.
struct Report {
  int service = 0, subtype = 0;
  int destination = 0;
  std::uint16_t counter = 0, sequence = 0;
  UtcNs time = 0;
  Bytes data;
  bool operator==(const std::pair<int, int>& type) const { return service == type.first && subtype == type.second; }
};

class TelecommandTest : public ComponentTest {
 protected:
  FailingStore failing{store};  ///< as the components see the store
  static constexpr std::uint16_t apid = 0x0EF;

  void SetUp() override {
    mission.telecommands_per_s = 10000;
    mission.capture_mode = CaptureMode::telecommanded;
    begin();
  }
  /// Again on the same store, as after a power cut. The first parameters are those of the mission file.
  void begin() {
    telecommander.reset();
    if (router == nullptr) router = std::make_unique<PacketRouter>(&link, nullptr, clock, mission);
    writer = std::make_unique<TelemetryWriter>(*router, clock, mission);
    telecommander = std::make_unique<Telecommander>(failing, *router, *writer, clock, mission);
    ASSERT_TRUE(telecommander->restore().ok());
  }

  /// Its sequence count, which counts on.
  std::uint16_t send(int service, int subtype, const Bytes& data = {}, std::uint16_t source = 1,
                     std::uint8_t flags = 0x0F) {
    link.up.push_back(packet(service, subtype, data, source, flags));
    return static_cast<std::uint16_t>(count - 1);
  }
  Bytes packet(int service, int subtype, const Bytes& data = {}, std::uint16_t source = 1, std::uint8_t flags = 0x0F) {
    Telecommand telecommand;
    telecommand.primary.apid = apid;
    telecommand.primary.sequence_count = count++;
    telecommand.ack_flags = flags;
    telecommand.service = static_cast<std::uint8_t>(service);
    telecommand.subtype = static_cast<std::uint8_t>(subtype);
    telecommand.source = source;
    telecommand.data = data;
    Bytes octets(13 + data.size());
    std::size_t bytes = 0;
    EXPECT_TRUE(encode_telecommand(telecommand, octets, bytes).ok());
    return octets;
  }
  void step() {
    for (int i = 0; i < 3; ++i) {
      const StepResult result = telecommander->step();
      EXPECT_TRUE(result.status.ok()) << status_name(result.status.code);
    }
  }
  void step_at(TimeNs time) {
    clock.set(time);
    step();
  }
  std::vector<Report> received() {
    std::vector<Report> reports;
    for (const Bytes& octets : link.down) {
      Telemetry telemetry;
      const Status status = decode_telemetry(octets, apid, TimeFormat{}, telemetry);
      EXPECT_TRUE(status.ok()) << status_name(status.code);
      Report report;
      report.service = telemetry.service;
      report.subtype = telemetry.subtype;
      report.destination = telemetry.destination;
      report.counter = telemetry.counter;
      report.sequence = telemetry.primary.sequence_count;
      report.time = telemetry.time;
      report.data.assign(telemetry.data.begin(), telemetry.data.end());
      reports.push_back(report);
    }
    link.down.clear();
    return reports;
  }
  /// "1.1 1.3 17.2 1.7": what has come down since the last time.
  std::string types() {
    std::string text;
    for (const Report& report : last_report = received()) {
      text += (text.empty() ? "" : " ") + std::to_string(report.service) + "." + std::to_string(report.subtype);
    }
    return text;
  }
  static std::uint32_t request_of(const Report& report) {
    ByteReader in(report.data);
    return in.u32();
  }
  static std::uint32_t request_of(std::uint16_t sequence) { return 0x18EFC000U + sequence; }
  /// The code of a failure report.
  static StatusCode code_of(const Report& report) {
    ByteReader in(report.data);
    static_cast<void>(in.u32());
    return static_cast<StatusCode>(in.u16());
  }
  static std::int64_t value_of(const Report& report, std::size_t index) {
    ByteReader in(report.data);
    static_cast<void>(in.take(6 + 8 * index));
    return static_cast<std::int64_t>(in.number(8));
  }
  /// The single failure that came: "1.4 function_unknown".
  std::string failure() {
    std::string text;
    for (const Report& report : last_report = received()) {
      if (report.service != 1 || report.subtype % 2 != 0) continue;
      text += (text.empty() ? "1." : " 1.") + std::to_string(report.subtype) + " " + status_name(code_of(report));
    }
    return text;
  }
  /// What comes down in the step after this telecommand.
  std::string types_after(int service, int subtype, const Bytes& data = {}, std::uint16_t source = 1,
                          std::uint8_t flags = 0x0F) {
    send(service, subtype, data, source, flags);
    step();
    return types();
  }
  std::string failure_after(int service, int subtype, const Bytes& data = {}, std::uint16_t source = 1,
                            std::uint8_t flags = 0x0F) {
    send(service, subtype, data, source, flags);
    step();
    return failure();
  }
  Bytes octets_of(UtcNs utc) const {
    Bytes octets(7);
    ByteWriter out(octets);
    EXPECT_TRUE(encode_time(TimeFormat{}, utc, out).ok());
    return octets;
  }
  Bytes time_of(TimeNs mission_ns) const { return octets_of(writer->settings().time.utc(mission_ns)); }
  static Bytes function(const char* name, const Bytes& arguments = {}) {
    Bytes data(8, 0);
    for (std::size_t i = 0; name[i] != 0; ++i) data[i] = static_cast<std::uint8_t>(name[i]);
    data.insert(data.end(), arguments.begin(), arguments.end());
    return data;
  }
  static Bytes numbers(std::initializer_list<std::pair<std::uint64_t, std::size_t>> list) {
    Bytes octets(64);
    ByteWriter out(octets);
    for (const auto& [value, width] : list) out.number(value, width);
    octets.resize(out.size());
    return octets;
  }
  static std::uint16_t id_of(const char* section, const char* key) {
    return parameter_info(find_parameter(section, key)).number;
  }
  CommandRecord last_command() {
    CommandRecord command;
    EXPECT_TRUE(last(store, command).ok());
    return command;
  }
  /// Writes what the overlap checker would write for a command.
  void let_overlap_checker_obey(std::int64_t command_id) {
    CheckpointRecord checkpoint{.id = static_cast<std::int64_t>(ComponentId::overlap_checker),
                                .cursor_second = command_id};
    write(checkpoint);
  }
  void answer_capture(const CommandRecord& command, CaptureState state, StatusCode reason = StatusCode::ok) {
    CaptureRecord capture;
    capture.id = number_of<CaptureRecord>() + 1;
    capture.requested_ns = command.at_ns;
    capture.source = CaptureSource::telecommand;
    capture.command_id = command.id;
    capture.state = state;
    capture.reason = static_cast<std::uint16_t>(reason);
    write(capture);
  }
  void expect_completion_with_exposure(const CommandRecord& command) {
    answer_capture(command, CaptureState::pending);
    step();
    EXPECT_EQ(types(), "");
    CaptureRecord capture = read<CaptureRecord>(number_of<CaptureRecord>());
    capture.state = CaptureState::exposed;
    write(capture);
    step();
    EXPECT_EQ(types(), "1.7");
  }

  QueueLink link;
  std::unique_ptr<PacketRouter> router;
  std::unique_ptr<TelemetryWriter> writer;
  std::unique_ptr<Telecommander> telecommander;
  std::vector<Report> last_report;
  std::uint16_t count = 0;
};

inline Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

}  // namespace ilp::test
