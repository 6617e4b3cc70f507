#include "sim/sil/real_time.hpp"

#include <csignal>
#include <iostream>
#include <stdexcept>

#include "bsp/flight/key_file.hpp"
#include "bsp/flight/mission_epoch.hpp"
#include "hal/clock/utc.hpp"
#include "sim/host/status_error.hpp"

namespace ilp::sil {
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

}  // namespace

void FlightClock::begin(Store& store, Configuration& configuration, MissionParameters& mission) {
  MissionTimeBegin begin;
  host::require(begin_mission_time(store, configuration.memory(), EpochChoice::first_start, utc_now(), mission, begin),
                "beginning mission time");
  configuration.epoch_is(mission.mission_epoch_s);
  real_clock_.set(begin.now);
}

std::unique_ptr<PacketLinks> open_links(const FlightOptions& options, Clock& clock) {
  auto links = std::make_unique<PacketLinks>(clock);
  const PacketLinkOptions addresses{text_or_null(options.link_udp), text_or_null(options.link_udp_peer),
                                    text_or_null(options.link_tcp), text_or_null(options.cfdp_udp),
                                    text_or_null(options.cfdp_udp_peer)};
  const char* culprit = nullptr;
  const Status status = links->open(addresses, culprit);
  if (!status.ok()) throw std::runtime_error("link " + std::string(culprit) + ": " + host::describe(status));
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

}  // namespace ilp::sil
