// A ground station that sends anything to the components that listen, on one store, in virtual time.
#include <array>
#include <cstddef>
#include <cstring>
#include <deque>
#include <optional>
#include <vector>

#include "fsw/commanding/function_table.hpp"
#include "fsw/commanding/settings.hpp"
#include "fsw/commanding/telecommander.hpp"
#include "fsw/downlink/delivery_queue.hpp"
#include "fsw/downlink/file_delivery.hpp"
#include "fsw/executive/event_log.hpp"
#include "fsw/packets/message_table.hpp"
#include "fsw/packets/service_functions.hpp"
#include "fsw/telemetry/telemetry.hpp"
#include "hal/store/ram/ram_store.hpp"
#include "tests/fuzz/pdu_choices.hpp"
#include "tests/support/fake_clock.hpp"
#include "tests/support/step_memory.hpp"

namespace ilp::fuzz {
namespace {

constexpr std::uint16_t apid = 0x0EF;

/// Both links of the package: what the ground sends waits here, what comes down is read.
class GroundLink final : public PacketLink {
 public:
  explicit GroundLink(bool pdus) : pdus_(pdus) {}
  Status receive(std::span<std::uint8_t> buffer, std::size_t& bytes) override {
    if (up_.empty()) return StatusCode::not_ready;
    bytes = up_.front().size();
    if (bytes <= buffer.size()) std::copy(up_.front().begin(), up_.front().end(), buffer.begin());
    up_.pop_front();
    return bytes <= buffer.size() ? StatusCode::ok : StatusCode::capacity_exceeded;
  }
  Status send(std::span<const std::uint8_t> packet) override {
    if (deaf) return StatusCode::not_ready;
    if (pdus_) {
      cfdp::Pdu pdu;
      if (!cfdp::decode(packet, pdu).ok()) fault = "a PDU that cannot be read";
      return {};
    }
    Telemetry telemetry;
    if (!decode_telemetry(packet, apid, *time, telemetry).ok()) fault = "a report that cannot be read";
    for (const MessageInfo& info : message_table()) {
      if (!info.telecommand && info.service == telemetry.service && info.subtype == telemetry.subtype) return {};
    }
    fault = "a report that is not in the table";
    return {};
  }
  void put(Octets octets) { up_.emplace_back(octets.begin(), octets.end()); }

  bool deaf = false;
  /// Nothing may be thrown through the flight software.
  const char* fault = nullptr;
  const TimeFormat* time = nullptr;

 private:
  bool pdus_;
  std::deque<std::vector<std::uint8_t>> up_;
};

class Session {
 public:
  explicit Session(Choices& choices) : choices_(choices), store_(region()), log_(store_) { start(); }

  void operate() {
    switch (choices_.byte() % 12) {
      case 0:
        packets_.put(choices_.bytes());
        break;
      case 1:
      case 2:
        telecommand();
        break;
      case 3:
      case 4:
        function();
        break;
      case 5:
        pdus_.put(choices_.bytes());
        break;
      case 6:
      case 7:
        pdu();
        break;
      case 8:
        rest();
        break;
      case 9:
        packets_.deaf = pdus_.deaf = (choices_.byte() & 1U) != 0;
        break;
      case 10:
        if ((choices_.byte() & 3U) == 0) {
          start();
        } else {
          happen();
        }
        break;
      default:
        queue_file();
        break;
    }
    frame();
  }

 private:
  struct Board {
    explicit Board(Session& s)
        : router(&s.packets_, &s.pdus_, s.clock_, s.mission_),
          writer(router, s.clock_, s.mission_),
          telecommander(s.store_, router, writer, s.clock_, s.mission_),
          delivery(s.store_, router, s.clock_, s.mission_, figures),
          telemetry(s.store_, router, writer, s.clock_, s.mission_, {nullptr, &figures.counts}) {}
    PacketRouter router;
    TelemetryWriter writer;
    Telecommander telecommander;
    DeliveryFigures figures;
    FileDelivery delivery;
    TelemetryReporter telemetry;
  };

  /// Large, and the same memory for all runs: to allocate it again takes longer than a run.
  static std::optional<Board>& board_memory() {
    static std::optional<Board> one;
    return one;
  }
  static std::optional<DeliveryQueue>& queue_memory() {
    static std::optional<DeliveryQueue> one;
    return one;
  }
  static std::span<std::byte> region() {
    static std::vector<std::byte> memory(std::size_t{8} << 20U);
    return memory;
  }

  /// As after a power cut.
  void start() {
    queue_memory().reset();
    mission_ = {};
    const Status settings = load_settings(store_, mission_);
    require(settings.ok() || settings.is(StatusCode::setting_ignored), "settings that cannot be loaded");
    require(validate(mission_).ok(), "settings that contradict each other");
    // Another application identifier or tailoring would only hide what follows.
    mission_.apid = apid;
    board_ = &board_memory().emplace(*this);
    board_->writer.configure();
    packets_.time = &board_->writer.settings().tailoring.time;
    for (Component* const component : components()) good(component->restore());
  }
  std::array<Component*, 3> components() { return {&board_->telecommander, &board_->delivery, &board_->telemetry}; }
  static void good(const Status& status) { require(!status.is(StatusCode::assertion_failed), "an assertion"); }

  /// A few minor frames, up to 13 s apart: what waits for its time gets it.
  void rest() {
    const std::uint8_t choice = choices_.byte();
    for (int frames = choice % 8; frames >= 0; --frames) frame(minor_frame_ns << (choice >> 5U));
  }

  void frame(TimeNs length = minor_frame_ns) {
    clock_.sleep_until(clock_.now() + length);
    for (Component* const component : components()) {
      const StepResult result = component->step();
      good(result.status);
      if (!result.status.ok()) log_.report(clock_.now(), component->name(), result.status);
    }
    for (const GroundLink* const link : {&packets_, &pdus_}) require(link->fault == nullptr, link->fault);
  }

  void send(std::uint8_t service, std::uint8_t subtype, Octets data) {
    Telecommand telecommand;
    telecommand.primary.apid = apid;
    telecommand.primary.sequence_count = count_++ & 0x3FFFU;
    telecommand.service = service;
    telecommand.subtype = subtype;
    telecommand.source = 1;
    telecommand.data = data;
    std::array<std::uint8_t, 1024> octets;
    std::size_t bytes = 0;
    require(encode_telecommand(telecommand, octets, bytes).ok(), "encoding");
    packets_.put(Octets(octets).first(bytes));
  }
  void telecommand() {
    const std::uint8_t choice = choices_.byte();
    const std::span<const MessageInfo> table = message_table();
    const MessageInfo& info = table[choice % table.size()];
    send(info.service, choice < 250 ? info.subtype : choices_.byte(), choices_.bytes());
  }
  void function() {
    const std::span<const FunctionInfo> table = function_table();
    const FunctionInfo& info = table[choices_.byte() % table.size()];
    std::array<std::uint8_t, 64> octets{};
    ByteWriter out(octets);
    for (std::size_t i = 0; i < function_name_bytes; ++i) {
      out.u8(static_cast<std::uint8_t>(i < std::strlen(info.name) ? info.name[i] : 0));
    }
    const LinkSettings& settings = board_->writer.settings();
    if (info.has_time) {
      const TimeNs at = clock_.now() + static_cast<TimeNs>(choices_.u16()) * ns_per_ms;
      require(encode_time(settings.tailoring.time, settings.time.utc(at), out).ok(), "a time");
    }
    out.put(choices_.take(std::size_t{info.bytes} + choices_.byte() % 10U));
    send(function_management::service, function_management::perform, out.written());
  }
  void pdu() {
    PduCapacity capacity;
    const std::uint8_t who = choices_.byte();
    cfdp::Header header{.toward_sender = (who & 2U) != 0, .crc = (who & 1U) != 0};
    // A PDU of a file on its way down, or of a file from the ground.
    header.source = header.toward_sender ? 1 : 2;
    header.destination = header.toward_sender ? 2 : 1;
    header.sequence_length = (who & 4U) != 0 ? 3 : 2;
    header.sequence = (who >> 3U) % 8U;
    const cfdp::Pdu pdu = choose_pdu(choices_, header, 3000, capacity);
    std::array<std::uint8_t, limits::max_pdu_bytes> octets;
    std::size_t bytes = 0;
    if (cfdp::encode(pdu, octets, bytes).ok()) pdus_.put(Octets(octets).first(bytes));
  }
  /// What other components would write.
  void happen() {
    log_.report(clock_.now(), "acquisition", {static_cast<StatusCode>(1 + choices_.byte() % 64U), choices_.byte(), 2});
    CommandRecord command;
    if (!last(store_, command).ok()) return;
    CaptureRecord capture;
    static_cast<void>(last(store_, capture));
    ++capture.id;
    capture.command_id = command.id;
    capture.requested_ns = command.at_ns;
    capture.state = static_cast<CaptureState>(choices_.byte() % static_cast<unsigned>(CaptureState::count));
    Transaction transaction(store_);
    if (transaction.begin().ok() && put(store_, capture).ok()) static_cast<void>(transaction.commit());
  }
  void queue_file() {
    std::array<std::uint8_t, 3000> file{};
    const std::size_t bytes = choices_.u16() % file.size();
    char name[] = "file-0";
    name[5] = static_cast<char>('0' + choices_.byte() % 8);
    Transaction transaction(store_);
    if (!transaction.begin().ok()) return;
    std::optional<DeliveryQueue>& queue = queue_memory();
    if (!queue) queue.emplace(store_, clock_, mission_, test::step_memory<DeliveryQueue>());
    if (!queue->begin_file(name).ok() || !queue->write(std::span(file).first(bytes)).ok()) return;
    if (queue->end_file().ok()) static_cast<void>(transaction.commit());
  }

  Choices& choices_;
  test::StillClock clock_;
  MissionParameters mission_;
  RamStore store_;
  EventLog log_;
  GroundLink packets_{false};
  GroundLink pdus_{true};
  Board* board_ = nullptr;
  std::uint16_t count_ = 0;
};

}  // namespace

void session(Octets input) {
  Choices choices(input);
  Session run(choices);
  for (int i = 0; i < 64 && !choices.empty(); ++i) run.operate();
}

}  // namespace ilp::fuzz
