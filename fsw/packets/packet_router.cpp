#include "fsw/packets/packet_router.hpp"

#include <algorithm>

#include "fsw/base/argument.hpp"
#include "fsw/packets/pass_schedule.hpp"
#include "fsw/packets/space_packet.hpp"

namespace ilp {
namespace {

constexpr std::size_t header_bytes = 6;
/// Shortest fixed part of a PDU's header with IDs and sequence number of one octet each.
constexpr std::size_t shortest_pdu_bytes = 7;
constexpr std::uint16_t unsegmented_word = unsegmented << 14U;
constexpr std::uint16_t sequence_mask = 0x3FFF;
constexpr double burst_s = 0.25;
/// What a link may cost in one minor frame, in octets. A packet costs its length and what its authentication costs at
/// least. What is left waits in the link. The datagram that goes beyond is taken whole.
constexpr std::size_t most_work_per_pump = std::size_t{512} << 10U;
constexpr std::size_t work_of_a_packet = 256;
constexpr double ns_in_a_second = 1e9;

std::uint16_t word(std::span<const std::uint8_t> bytes, std::size_t at) {
  return static_cast<std::uint16_t>((bytes[at] << 8U) | bytes[at + 1]);
}
void set_word(std::span<std::uint8_t> bytes, std::size_t at, std::size_t value) {
  bytes[at] = static_cast<std::uint8_t>(value >> 8U);
  bytes[at + 1] = static_cast<std::uint8_t>(value);
}

bool version_is_right(std::span<const std::uint8_t> packet) {
  return (packet[0] >> 5U) == 0;
}
bool is_telecommand(std::span<const std::uint8_t> packet) {
  return (packet[0] & 0x10U) != 0;
}
std::uint16_t apid_of(std::span<const std::uint8_t> packet) {
  return word(packet, 0) & 0x7FFU;
}
std::size_t length_of(std::span<const std::uint8_t> packet) {
  return header_bytes + word(packet, 4) + 1U;
}

}  // namespace

PacketRouter::PacketRouter(PacketLink* packets, PacketLink* files, Clock& clock, const MissionParameters& mission)
    : packets_(packets), files_(files), clock_(clock), mission_(mission) {}

void PacketRouter::Bucket::fill(TimeNs now, double per_s, double most) {
  const TimeNs since = begun ? now - filled_ns : 0;
  level = begun ? std::min(most, level + per_s * static_cast<double>(since) / ns_in_a_second) : most;
  filled_ns = now;
  begun = true;
}

bool PacketRouter::authenticating() const {
  return authentication_wanted() && authenticator_ != nullptr && !authenticator_->empty();
}

bool PacketRouter::pdus_protected() const {
  return authenticating() && mission_.authentication == Authentication::telecommands_and_files;
}

bool PacketRouter::contact() const {
  return contact_at(mission_, clock_.now()).open;
}

Status PacketRouter::pump() {
  Status first;
  if (packets_ != nullptr) first = drain(*packets_, false);
  const Status second = files_ != nullptr ? drain(*files_, true) : Status{};
  return first.ok() ? second : first;
}

Status PacketRouter::drain(PacketLink& link, bool whole_pdus) {
  const bool open = contact();
  work_ = 0;
  for (std::size_t i = 0; i < limits::max_datagrams_per_pump && work_ < most_work_per_pump; ++i) {
    std::size_t bytes = 0;
    const Status status = link.receive(buffer_, bytes);
    if (status.is(StatusCode::not_ready)) return {};
    if (status.is(StatusCode::capacity_exceeded)) {
      ++counts_.malformed;
      continue;
    }
    if (!status.ok()) return status;
    const auto datagram = std::span(buffer_).first(std::min(bytes, buffer_.size()));
    if (!open) {
      ++counts_.dropped;
    } else if (!whole_pdus) {
      sort(link, datagram);
    } else if (pdus_protected()) {
      ++counts_.refused;
      last_refusal_ = StatusCode::authentication_missing;
    } else if (take_pdu(datagram)) {
      link.accept_sender();
    }
  }
  return {};
}

void PacketRouter::sort(PacketLink& link, std::span<std::uint8_t> datagram) {
  bool accepted = false;
  // Every turn removes at least a header from the datagram.
  while (!datagram.empty()) {
    if (datagram.size() < header_bytes || !version_is_right(datagram)) {
      ++counts_.malformed;
      break;
    }
    const std::size_t length = length_of(datagram);
    const bool whole = length <= datagram.size();
    const auto packet = datagram.first(whole ? length : datagram.size());
    work_ += packet.size() + work_of_a_packet;
    accepted = take_packet(packet, whole) || accepted;
    datagram = datagram.subspan(packet.size());
  }
  if (accepted) link.accept_sender();
}

bool PacketRouter::authentic(std::span<std::uint8_t>& packet) {
  std::size_t bytes = 0;
  const Status status = authenticator_->open(packet, bytes);
  if (!status.ok()) {
    ++counts_.refused;
    last_refusal_ = status;
    return false;
  }
  packet = packet.first(bytes);
  return true;
}

bool PacketRouter::take_packet(std::span<std::uint8_t> packet, bool whole) {
  const std::uint16_t apid = apid_of(packet);
  if (!whole) ++counts_.malformed;
  if (apid == cfdp_apid ? pdus_protected() : authenticating()) {
    if (!whole || !authentic(packet)) return false;
  }
  if (apid == cfdp_apid) return whole && take_pdu(packet.subspan(header_bytes));
  const bool ours = apid == mission_.apid;
  if (!ours) ++counts_.unknown_apid;
  if (apid == idle_apid) return false;
  if (!is_telecommand(packet)) {
    if (ours && whole) ++counts_.malformed;
    return false;
  }
  if (!commands_.push(packet)) {
    ++counts_.dropped;
    return false;
  }
  ++waiting_;
  ++counts_.received;
  return true;
}

bool PacketRouter::take_pdu(std::span<const std::uint8_t> pdu) {
  // The version since the standard's fifth issue, and the version before it.
  if (pdu.size() < shortest_pdu_bytes || (pdu[0] >> 5U) > 1) {
    ++counts_.malformed;
    return false;
  }
  if (!pdus_.push(pdu)) {
    ++counts_.dropped;
    return false;
  }
  ++counts_.received;
  return true;
}

Status PacketRouter::receive(Channel channel, std::span<std::uint8_t> out, std::size_t& bytes) {
  bytes = 0;
  if (channel == Channel::files) return pdus_.pop(out, bytes);
  if (channel != Channel::commands) return out_of_range(Argument::channel, static_cast<std::uint8_t>(channel));
  if (authenticating() && released_ == 0) return StatusCode::not_ready;
  command_credit_.fill(clock_.now(), mission_.telecommands_per_s, mission_.telecommands_per_s);
  if (command_credit_.level < 1) return StatusCode::not_ready;
  const Status status = commands_.pop(out, bytes);
  if (status.is(StatusCode::not_ready)) return status;
  command_credit_.level -= 1;
  --waiting_;
  if (released_ > 0) --released_;
  return status;
}

Status PacketRouter::send(Channel channel, std::span<const std::uint8_t> packet) {
  if (channel != Channel::commands && channel != Channel::files) {
    return out_of_range(Argument::channel, static_cast<std::uint8_t>(channel));
  }
  if (!contact()) return StatusCode::not_ready;
  const double rate = mission_.link_bytes_per_s;
  link_credit_.fill(clock_.now(), rate, rate * burst_s);
  const double least = channel == Channel::commands ? -rate * burst_s : 0;
  if (!(link_credit_.level > least)) return StatusCode::not_ready;
  return put_out(channel, packet);
}

Status PacketRouter::put_out(Channel channel, std::span<const std::uint8_t> packet) {
  const bool wrapped = channel == Channel::files && files_ == nullptr;
  PacketLink* link = channel == Channel::files && !wrapped ? files_ : packets_;
  if (link == nullptr) return StatusCode::not_ready;
  if (wrapped) {
    if (packet.empty() || packet.size() + header_bytes > buffer_.size()) {
      return {StatusCode::capacity_exceeded, static_cast<std::int64_t>(packet.size()),
              static_cast<std::int64_t>(buffer_.size() - header_bytes)};
    }
    set_word(buffer_, 0, cfdp_apid);
    set_word(buffer_, 2, unsegmented_word | file_packets_);
    set_word(buffer_, 4, packet.size() - 1);
    std::copy(packet.begin(), packet.end(), buffer_.begin() + header_bytes);
    packet = std::span<const std::uint8_t>(buffer_).first(header_bytes + packet.size());
  }
  ILP_TRY(link->send(packet));
  if (wrapped) file_packets_ = (file_packets_ + 1U) & sequence_mask;
  link_credit_.level -= static_cast<double>(packet.size());
  ++counts_.sent;
  return {};
}

}  // namespace ilp
