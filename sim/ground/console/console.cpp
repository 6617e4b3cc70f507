#include "sim/ground/console/console.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "fsw/packets/packet_router.hpp"
#include "fsw/packets/service_verification.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::console {
namespace {

constexpr int shortest_wait_ms = 20;

std::unique_ptr<PacketSocket> open_cfdp(const ConsoleSettings& settings) {
  return settings.cfdp ? std::make_unique<PacketSocket>(Transport::udp, *settings.cfdp, settings.cfdp_local) : nullptr;
}

ground_cfdp::CfdpSenderSettings sender_settings() {
  ground_cfdp::CfdpSenderSettings settings;
  settings.sequence_length = 8;
  return settings;
}

}  // namespace

std::size_t take_packets(std::span<const std::uint8_t> octets, std::uint16_t apid, const Tailoring& tailoring,
                         const std::function<void(Report)>& report,
                         const std::function<void(std::span<const std::uint8_t>)>& pdu) {
  std::size_t malformed = 0;
  std::span<const std::uint8_t> packet;
  while (!octets.empty()) {
    PrimaryHeader primary;
    if (!first_packet(octets, packet).ok() || !decode_primary(packet, primary).ok()) return malformed + 1;
    octets = octets.subspan(packet.size());
    if (primary.apid == cfdp_apid) {
      pdu(packet.subspan(primary_header_bytes));
      continue;
    }
    Report one;
    if (!decode_telemetry(packet, apid, tailoring.time, one.header).ok()) {
      ++malformed;
      continue;
    }
    one.data.assign(one.header.data.begin(), one.header.data.end());
    one.header.data = {};
    report(std::move(one));
  }
  return malformed;
}

Console::Console(ConsoleSettings settings)
    : settings_(std::move(settings)),
      socket_(settings_.transport, settings_.board),
      cfdp_socket_(open_cfdp(settings_)),
      receiver_(std::make_unique<ground_cfdp::CfdpReceiver>(
          ground_cfdp::CfdpReceiverSettings{}, [this](const Bytes& pdu) { send_pdu(pdu); },
          [this](const std::string& name, const Bytes& file) {
            if (settings_.keep && !settings_.keep(name, file)) return false;
            if (settings_.remember_files) files_[name] = file;
            return true;
          })),
      sender_(
          std::make_unique<ground_cfdp::CfdpSender>(sender_settings(), [this](const Bytes& pdu) { send_pdu(pdu); })) {
  seal_files(settings_.seal_files);
}

void Console::seal_files(bool wanted) {
  if (wanted && settings_.spi == 0) throw std::runtime_error("files cannot be authenticated without a key");
  if (wanted && cfdp_socket_) throw std::runtime_error("bare PDUs cannot be authenticated: files must go in packets");
  settings_.seal_files = wanted;
}

std::uint64_t Console::put_file(const std::string& name, const Bytes& file) {
  const std::uint64_t number = settings_.numbers ? settings_.numbers->next_transaction() : ++next_transaction_;
  return sender_->put(name, file, now_s(), number);
}

Console::Bytes Console::build(std::uint8_t service, std::uint8_t subtype, const Bytes& data) {
  Telecommand telecommand;
  telecommand.primary.telecommand = true;
  telecommand.primary.apid = settings_.apid;
  telecommand.primary.sequence_count = next_count_;
  next_count_ = static_cast<std::uint16_t>((next_count_ + 1U) % sequence_counts);
  telecommand.service = service;
  telecommand.subtype = subtype;
  telecommand.source = settings_.source;
  telecommand.data = data;
  Bytes packet(telecommand_overhead_bytes + data.size());
  std::size_t bytes = 0;
  host::require(encode_telecommand(telecommand, packet, bytes), "encoding a telecommand");
  packet.resize(bytes);
  return packet;
}

Console::Bytes Console::sealed(const Bytes& packet) {
  if (settings_.spi == 0) return packet;
  Bytes out(packet.size() + security_bytes);
  std::size_t bytes = 0;
  const std::uint32_t sequence =
      settings_.numbers ? settings_.numbers->next_sequence(settings_.spi) : ++settings_.sequence;
  host::require(seal(packet, settings_.spi, sequence, settings_.key, out, bytes), "sealing a packet");
  out.resize(bytes);
  return out;
}

std::uint32_t Console::request_of(const Bytes& packet) {
  return ByteReader(packet).u32();
}

std::uint32_t Console::command(std::uint8_t service, std::uint8_t subtype, const Bytes& data) {
  const Bytes packet = build(service, subtype, data);
  socket_.send(sealed(packet));
  return request_of(packet);
}

void Console::send_pdu(const Bytes& pdu) {
  if (cfdp_socket_) {
    cfdp_socket_->send(pdu);
    return;
  }
  PrimaryHeader header;
  header.telecommand = true;
  header.secondary_header = false;
  header.apid = cfdp_apid;
  header.sequence_count = next_pdu_count_;
  header.data_length = static_cast<std::uint16_t>(pdu.size() - 1);
  next_pdu_count_ = static_cast<std::uint16_t>((next_pdu_count_ + 1U) % sequence_counts);
  Bytes packet(primary_header_bytes + pdu.size());
  ByteWriter writer(packet);
  encode_primary(header, writer);
  writer.put(pdu);
  socket_.send(settings_.seal_files ? sealed(packet) : packet);
}

void Console::take_pdu(std::span<const std::uint8_t> pdu) {
  if (settings_.take_files) receiver_->receive(pdu, now_s());
  sender_->receive(pdu, now_s());
}

void Console::take(const Bytes& datagram) {
  malformed_ += take_packets(
      datagram, settings_.apid, settings_.tailoring, [this](Report report) { reports_.push_back(std::move(report)); },
      [this](std::span<const std::uint8_t> pdu) { take_pdu(pdu); });
}

bool Console::listen(double seconds, const std::function<bool()>& done) {
  const double end = now_s() + seconds;
  while (!done || !done()) {
    const double left = end - now_s();
    if (left <= 0) return false;
    if (closed()) {
      // Nothing more can come. A caller that listens in a loop must not take the whole processor.
      std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, 0.1)));
      return false;
    }
    const int wait_ms = std::min(shortest_wait_ms, static_cast<int>(1000 * left) + 1);
    for (const Bytes& datagram : socket_.receive(wait_ms)) take(datagram);
    if (cfdp_socket_) {
      for (const Bytes& pdu : cfdp_socket_->receive(0)) take_pdu(pdu);
    }
    receiver_->tick(now_s());
    sender_->tick(now_s());
  }
  return true;
}

std::vector<int> Console::verification_of(std::uint32_t request) const {
  std::vector<int> subtypes;
  for (const Report& report : reports_) {
    if (report.header.service != verification::service) continue;
    if (ByteReader(report.data).u32() == request) subtypes.push_back(report.header.subtype);
  }
  return subtypes;
}

bool Console::completed(std::uint32_t request) const {
  const std::vector<int> subtypes = verification_of(request);
  return std::find(subtypes.begin(), subtypes.end(), int{verification::completion}) != subtypes.end();
}

std::size_t Console::count(std::uint8_t service, std::uint8_t subtype) const {
  return static_cast<std::size_t>(std::count_if(reports_.begin(), reports_.end(), [&](const Report& report) {
    return report.header.service == service && report.header.subtype == subtype;
  }));
}

}  // namespace ilp::console
