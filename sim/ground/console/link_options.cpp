#include "sim/ground/console/link_options.hpp"

#include <array>
#include <cerrno>
#include <memory>
#include <sstream>
#include <stdexcept>

#include "cfg/mission.hpp"
#include "hal/posix/private_file.hpp"
#include "sim/host/files.hpp"

namespace ilp::console {
namespace {

SocketAddress address_of(const std::string& text) {
  SocketAddress address;
  if (!parse_address(text.c_str(), address).ok() || address.port == 0) {
    throw std::runtime_error("an address is written 127.0.0.1:10025, not " + text);
  }
  return address;
}

std::vector<std::uint8_t> octets_of(const std::string& hex) {
  std::vector<std::uint8_t> octets;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    octets.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return octets;
}

bool is_hex(const std::string& text) {
  return text.size() % 2 == 0 && text.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
}

std::string text_of_keys(const std::string& path) {
  std::array<std::uint8_t, 4096> text{};
  std::size_t size = 0;
  const Status status = read_private_file(path.c_str(), text, size);
  if (status.is(StatusCode::file_not_private)) {
    throw std::runtime_error("others may read the file of keys " + path + ": run chmod 600 " + path);
  }
  if (!status.ok()) {
    const int error = status.is(StatusCode::not_found) ? ENOENT : static_cast<int>(status.a);
    throw std::runtime_error("cannot read the file of keys " + path + ": " + host::read_failure(error));
  }
  return {reinterpret_cast<const char*>(text.data()), size};
}

// The file has a line `SPI KEY` for each key, as the flight's has. The first key counts unless an SPI is given.
void read_key(const LinkOptions& options, ConsoleSettings& settings) {
  std::istringstream in(text_of_keys(options.key));
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::uint16_t spi = 0;
    std::string hex;
    if (!(words >> spi >> hex) || (options.spi != 0 && spi != options.spi)) continue;
    const bool good = is_hex(hex) && hex.size() >= 2 * min_key_bytes && hex.size() <= 2 * max_key_bytes;
    if (!good || spi == 0)
      throw std::runtime_error(options.key + ": a line is an SPI and 16 to 64 octets in hexadecimal");
    settings.spi = spi;
    settings.key = octets_of(hex);
    return;
  }
  throw std::runtime_error(options.key + " has no key" +
                           (options.spi ? " of SPI " + std::to_string(options.spi) : std::string()));
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
  if (!options.key.empty()) read_key(options, settings.link);
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
  app.add_option("--spi", options.spi, "SPI of the key that is used (default: the first key of the file)");
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
