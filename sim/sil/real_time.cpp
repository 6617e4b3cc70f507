#include "sim/sil/real_time.hpp"

#include <csignal>
#include <fstream>
#include <iostream>
#include <iterator>
#include <stdexcept>
#include <vector>

#include "bsp/flight/key_file.hpp"
#include "fsw/base/crc.hpp"
#include "fsw/base/rng.hpp"
#include "hal/store/record_bytes.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::sil {
namespace fs = std::filesystem;
namespace {

volatile std::sig_atomic_t stop = 0;

const char* text_or_null(const std::string& text) {
  return text.empty() ? nullptr : text.c_str();
}

void print_address(const char* what, const SocketAddress& address) {
  if (address == SocketAddress{}) return;
  std::cerr << "ilp-sil: " << what << " at " << (address.host >> 24U) << "." << ((address.host >> 16U) & 255U) << "."
            << ((address.host >> 8U) & 255U) << "." << (address.host & 255U) << ":" << address.port << "\n";
}

std::uint64_t fingerprint_of(Store& store) {
  std::uint64_t hash = 0;
  const auto add = [&hash](std::int64_t value) { hash = mix64(hash ^ static_cast<std::uint64_t>(value)); };
  for (std::size_t t = 0; t < static_cast<std::size_t>(RecordType::count); ++t) {
    const auto type = static_cast<RecordType>(t);
    if ((mask_of(type) & mask_of(RecordType::event, RecordType::component, RecordType::timing)) != 0) continue;
    alignas(8) std::uint8_t record[limits::max_record_bytes] = {};
    add(store.last(record_info(type), record).ok() ? id_of(record) : 0);
  }
  CheckpointRecord checkpoint;
  for (std::int64_t id = 0; next(store, id, checkpoint).ok(); id = checkpoint.id) {
    add(checkpoint.cursor);
    add(checkpoint.cursor_second);
  }
  return hash;
}

}  // namespace

std::unique_ptr<PacketLinks> open_links(const FlightOptions& options, Clock& clock) {
  auto links = std::make_unique<PacketLinks>(clock);
  const PacketLinkOptions addresses{text_or_null(options.link_udp), text_or_null(options.link_udp_peer),
                                    text_or_null(options.link_tcp), text_or_null(options.cfdp_udp),
                                    text_or_null(options.cfdp_udp_peer)};
  const char* culprit = nullptr;
  const Status status = links->open(addresses, culprit);
  if (!status.ok()) throw std::runtime_error("link " + std::string(culprit) + ": " + link_advice(status));
  PacketLinks::Addresses used;
  host::require(links->addresses(used), "the links' addresses");
  print_address("packets over UDP", used.udp);
  print_address("packets over TCP", used.tcp);
  print_address("CFDP over UDP", used.cfdp);
  return links;
}

void read_keys(const FlightOptions& options, const MissionParameters& mission, Authenticator& keys) {
  if (!options.key_file.empty())
    host::require(read_key_file(options.key_file.c_str(), keys), "--key " + options.key_file);
  if (keys.empty() && options.linked() && mission.authentication != Authentication::none)
    throw std::runtime_error("[link] authentication of the mission needs --key");
}

void catch_stop_signals() {
  const auto handler = [](int) { stop = 1; };
  std::signal(SIGTERM, handler);
  std::signal(SIGINT, handler);
}

bool stop_requested() {
  return stop != 0;
}

bool StallGuard::stalled(Store& store, TimeNs now) {
  const std::uint64_t fingerprint = fingerprint_of(store);
  if (changed_ns_ < 0 || fingerprint != fingerprint_) changed_ns_ = now;
  fingerprint_ = fingerprint;
  return now - changed_ns_ > longest_;
}

Receiver::Receiver(fs::path outbox, fs::path acknowledgements)
    : outbox_(std::move(outbox)), acknowledgements_(std::move(acknowledgements)) {}

void Receiver::receive() {
  for (const auto& entry : fs::directory_iterator(outbox_)) {
    const std::string name = entry.path().filename().string();
    if (!entry.is_regular_file() || entry.path().extension() == ".part" || seen_.count(name) != 0) continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::vector<char> content((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(content.data());
    std::ofstream(acknowledgements_ / (name + ".ack"))
        << content.size() << " " << crc32({bytes, content.size()}) << "\n";
    seen_.insert(name);
    bytes_ += content.size();
  }
}

}  // namespace ilp::sil
