#include "sim/ground/console/console.hpp"

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "fsw/link/packet_router.hpp"
#include "fsw/link/service_verification.hpp"
#include "sim/io/status_error.hpp"

namespace ilp::sim {
namespace {

constexpr int shortest_wait_ms = 20;

double now_s() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::unique_ptr<PacketSocket> open_cfdp(const ConsoleSettings& settings) {
  return settings.cfdp ? std::make_unique<PacketSocket>(Transport::udp, *settings.cfdp, settings.cfdp_local) : nullptr;
}

}  // namespace

Console::Console(ConsoleSettings settings)
    : settings_(std::move(settings)),
      socket_(settings_.transport, settings_.board),
      cfdp_socket_(open_cfdp(settings_)),
      receiver_(std::make_unique<CfdpReceiver>(
          CfdpReceiverSettings{}, [this](const Bytes& pdu) { send_pdu(pdu); },
          [this](const std::string& name, const Bytes& file) {
            if (settings_.keep && !settings_.keep(name, file)) return false;
            if (settings_.remember_files) files_[name] = file;
            return true;
          })) {}

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
  require(encode_telecommand(telecommand, packet, bytes), "encoding a telecommand");
  packet.resize(bytes);
  return packet;
}

Console::Bytes Console::sealed(const Bytes& packet) {
  if (settings_.spi == 0) return packet;
  Bytes out(packet.size() + security_bytes);
  std::size_t bytes = 0;
  require(seal(packet, settings_.spi, ++settings_.sequence, settings_.key, out, bytes), "sealing a telecommand");
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
  socket_.send(packet);
}

void Console::take(const Bytes& datagram) {
  std::span<const std::uint8_t> rest(datagram), packet;
  while (!rest.empty()) {
    PrimaryHeader primary;
    if (!first_packet(rest, packet).ok() || !decode_primary(packet, primary).ok()) {
      ++malformed_;
      return;
    }
    rest = rest.subspan(packet.size());
    if (primary.apid == cfdp_apid) {
      if (settings_.take_files) receiver_->receive(packet.subspan(primary_header_bytes), now_s());
      continue;
    }
    Report report;
    if (!decode_telemetry(packet, settings_.apid, settings_.tailoring.time, report.header).ok()) {
      ++malformed_;
      continue;
    }
    report.data.assign(report.header.data.begin(), report.header.data.end());
    report.header.data = {};
    reports_.push_back(std::move(report));
  }
}

bool Console::listen(double seconds, const std::function<bool()>& done) {
  const double end = now_s() + seconds;
  while (!done || !done()) {
    const double left = end - now_s();
    if (left <= 0) return false;
    if (closed()) {
      // Nothing can come any more; who asks again and again does not take the whole processor.
      std::this_thread::sleep_for(std::chrono::duration<double>(std::min(left, 0.1)));
      return false;
    }
    const int wait_ms = std::min(shortest_wait_ms, static_cast<int>(1000 * left) + 1);
    for (const Bytes& datagram : socket_.receive(wait_ms)) take(datagram);
    if (cfdp_socket_) {
      for (const Bytes& pdu : cfdp_socket_->receive(0)) receiver_->receive(pdu, now_s());
    }
    receiver_->tick(now_s());
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

}  // namespace ilp::sim
