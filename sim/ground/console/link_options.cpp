#include "sim/ground/console/link_options.hpp"

#include <memory>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "sim/host/key_file.hpp"

namespace ilp::console {
namespace {

SocketAddress address_of(const std::string& text) {
  SocketAddress address;
  if (!parse_address(text.c_str(), address).ok() || address.port == 0) {
    throw std::runtime_error("an address is written 127.0.0.1:10025, not " + text);
  }
  return address;
}

Tailoring tailoring_named(const std::string& name) {
  for (std::size_t i = 0; i < tailoring_count; ++i) {
    if (name == tailorings()[i].name)
      return tailoring_of(static_cast<GroundSystem>(i), false, MissionParameters{}.agency_epoch_s);
  }
  throw std::runtime_error("a tailoring is standard, fsfw or yamcs, not " + name);
}

}  // namespace

OperatorSettings operator_settings(const LinkOptions& options) {
  OperatorSettings settings;
  settings.link.transport = options.tcp ? Transport::tcp : Transport::udp;
  settings.link.board = address_of(options.address);
  if (!options.cfdp.empty()) settings.link.cfdp = address_of(options.cfdp);
  if (!options.cfdp_local.empty()) settings.link.cfdp_local = address_of(options.cfdp_local);
  settings.link.apid = options.apid;
  settings.link.source = options.source;
  settings.link.tailoring = tailoring_named(options.tailoring);
  if (!options.key.empty()) {
    const host::FileKey key = host::read_key_file(options.key, options.spi);
    settings.link.spi = key.spi;
    settings.link.key = key.octets;
  }
  const std::string numbers =
      options.numbers.empty() && !options.key.empty() ? options.key + ".numbers" : options.numbers;
  settings.link.numbers =
      numbers.empty() ? std::make_shared<StationNumbers>() : std::make_shared<StationNumbers>(numbers);
  if (options.seal_files == "yes") settings.seal_files = SealFiles::yes;
  if (options.seal_files == "no") settings.seal_files = SealFiles::no;
  return settings;
}

void add_link_options(CLI::App& app, LinkOptions& options) {
  app.add_flag("--tcp", options.tcp, "connect by TCP, not by UDP");
  app.add_option("--key", options.key, "key file; telecommands are then authenticated");
  app.add_option("--spi", options.spi, "SPI of the key that is used (default: the first key of the file)")
      ->default_str("");
  app.add_option("--numbers", options.numbers,
                 "file of the sequence numbers that this station has used (default: KEYFILE.numbers)");
  app.add_option("--apid", options.apid, "application process identifier of the flight")->check(CLI::Range(0, 2044));
  app.add_option("--source", options.source, "source identifier of this station; each station needs its own");
  app.add_option("--tailoring", options.tailoring,
                 "standard, fsfw or yamcs: the value of the flight's parameter link.tailoring");
}

void add_file_link_options(CLI::App& app, LinkOptions& options) {
  app.add_option("--cfdp", options.cfdp, "ADDRESS:PORT to which CFDP PDUs are sent bare, not in space packets");
  app.add_option("--cfdp-local", options.cfdp_local, "ADDRESS:PORT at which bare CFDP PDUs are received");
  app.add_option("--seal-files", options.seal_files,
                 "whether file transfers are authenticated: yes, no, or as-told: as the flight's parameter "
                 "link.authentication says")
      ->check(CLI::IsMember({"as-told", "yes", "no"}));
}

}  // namespace ilp::console
